// What the subcommands that read an armature share: its files, its port, words to a person.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "armature/controller/armature_reader.h"
#include "armature/controller/calibration.h"
#include "armature/description/armature.h"
#include "armature/simulation/simulated_box.h"
#include "core/io/text/line_input.h"

namespace CLI {
class App;
}

namespace keypose::armature {

struct PuppetFlags {
  std::string description;
  std::string port;         ///< a device, or "simulated"
  std::string calibration;  ///< "" with a simulated port
  std::string faults;       ///< of a simulated port
  int baud = 1000000;
};

/// Adds --description, --port, --baud, --calibration and --faults.
void AddPuppetFlags(CLI::App& app, PuppetFlags& flags);

/// The armature of a description file.
Armature LoadArmature(const std::filesystem::path& description);

/// Parses, answers --help, runs. Errors of the command line become UsageError.
int RunCommandLine(CLI::App& app, int argc, char** argv, const std::function<int()>& run);

/// The obstacle that mostly goes by itself.
inline constexpr const char* kPuppetMoves = "the puppet moves";

/// What a program does with the calibration file.
enum class CalibrationUse {
  kKept,      ///< it must be there and fit the description; it is kept up to date
  kMade,      ///< it is made anew; gear ratios of one that is there stay
  kNotNeeded  ///< it is neither read nor written
};

/// A puppet that is read, or one that is simulated in this program. Its calibration file is kept up
/// to date: at most once a second, and at the end. A simulated one's is not.
class Puppet {
 public:
  /// @throws UsageError, InputError, DiskError, ToolError
  explicit Puppet(const PuppetFlags& flags, CalibrationUse use = CalibrationUse::kKept);
  ~Puppet();

  /// The zero position is set: from now on the file is written.
  /// @return false: it is not, as the puppet is simulated, and the file may be a real one's
  bool KeepCalibration();
  /// Joints whose part of the calibration was for another description. Of kMade.
  const std::vector<std::string>& fresh_joints() const { return fresh_; }

  const Armature& armature() const { return armature_; }
  ArmatureReader& reader() { return *reader_; }
  /// The simulated puppet, or nullptr.
  SimulatedBox* simulated() { return simulated_.get(); }
  /// Reads once; writes the calibration file when that is due.
  const Reading& Poll();
  /// Whether nothing has moved by more than a count in the last tenth of a second.
  bool at_rest() const;
  /// The joint of that name.
  /// @throws UsageError  there is none; names the nearest
  std::size_t JointNamed(const std::string& name) const;
  const std::string& JointName(int joint) const;
  /// Why no frame can be taken now, in words; "" when one can. Asked again and again, until one
  /// can.
  /// @param moving_too  it is taken while the puppet moves
  std::string Obstacle(const Reading& reading, bool moving_too);
  /// A person has put this joint where it is known to stand.
  /// @param number  degrees; of a slide in the description's unit @throws UsageError, DiskError
  void SetJoint(const std::string& name, double number);
  /// @throws DiskError
  void SaveCalibration();

 private:
  void NoteRest(const Reading& reading);
  PuppetFlags flags_;
  Armature armature_;
  std::unique_ptr<SimulatedBox> simulated_;
  std::unique_ptr<ArmatureReader> reader_;
  std::vector<double> rest_values_;
  double rest_since_s_ = 0, now_s_ = 0, saved_s_ = 0;
  std::size_t moved_last_ = 0;  ///< a joint
  double waits_since_s_ = -1, waited_s_ = -1;
  std::string saved_;
  bool keeps_;
  std::vector<std::string> fresh_;
};

/// Tells a person a sentence, or a program a JSON line.
class Teller {
 public:
  explicit Teller(bool json) : json_(json) {}
  /// @param words   a sentence, for both
  /// @param fields  JSON text of an object with more; may be empty
  void Tell(const std::string& event, const std::string& words, const std::string& fields = "");
  void Tell(const ReaderEvent& event, const Puppet& puppet);

 private:
  bool json_;
};

}  // namespace keypose::armature
