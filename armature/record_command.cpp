// `keypose armature record`: frame after frame of a puppet, as a stop-motion animator poses it.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "armature/armature_commands.h"
#include "armature/example/theropod.h"
#include "armature/puppet.h"
#include "armature/recording/curve_edits.h"
#include "armature/recording/recording_session.h"
#include "armature/recording/still_joints.h"
#include "core/values/errors.h"

namespace keypose::armature {
namespace {

using nlohmann::json;

struct RecordFlags {
  PuppetFlags puppet;
  std::string session;
  RecordingOptions options;
  int frames = 0;
  bool json = false;
};

/// What is typed, what the puppet says, what is written.
class Recorder {
 public:
  Recorder(const RecordFlags& flags, Puppet& puppet, RecordingSession& session)
      : flags_(flags), puppet_(puppet), session_(session), teller_(flags.json) {
    std::string words = fmt::format("{} frames are recorded; frame {} is next",
                                    session.frame_count(), session.at());
    if (session.was_cut_off())
      words += "; the last line of the journal was cut off by a crash, and is forgotten";
    teller_.Tell("session", words, Place());
    PoseSimulated();
  }

  /// @return false when the session has ended
  bool Step(const std::optional<std::string>& line) {
    const Reading& reading = puppet_.Poll();
    for (const ReaderEvent& event : puppet_.reader().TakeEvents()) teller_.Tell(event, puppet_);
    if (line && !Do(*line)) return false;
    if (flags_.frames > 0) wants_frame_ = true;
    if (wants_frame_) TryToRecord(reading);
    return flags_.frames == 0 || session_.frame_count() < flags_.frames;
  }

 private:
  std::string Place() const {
    return json{{"frames", session_.frame_count()}, {"at", session_.at()}}.dump();
  }

  bool Do(const std::string& line) {
    std::istringstream words(line);
    std::string word, name;
    words >> word;
    try {
      if (word == "end" || word == "quit") return false;
      if (word.empty() || word == "record") return WantFrame();
      wants_frame_ = false;
      if (word == "next") return GoTo(session_.at() + 1);
      if (word == "back") return GoTo(session_.at() - 1);
      if (int frame = 0; word == "goto" && words >> frame) return GoTo(frame);
      if (word == "cut") return Cut();
      if (word == "zero" && words >> name) return Set(name, 0);
      if (double number = 0; word == "set" && words >> name >> number) return Set(name, number);
      if (word == "pose") return TellPose();
      teller_.Tell("refused",
                   fmt::format("'{}' is not understood; type record, next, back, goto N, "
                               "cut, zero JOINT, set JOINT DEGREES, pose or end",
                               line));
    } catch (const UsageError& error) {
      teller_.Tell("refused", error.what());
    }
    return true;
  }

  bool WantFrame() {
    wants_frame_ = true;
    told_waiting_ = false;
    return true;
  }

  bool GoTo(int frame) {
    session_.GoTo(frame);
    teller_.Tell("at", fmt::format("frame {} is next", session_.at()), Place());
    PoseSimulated();
    return true;
  }

  bool Cut() {
    session_.CutHere();
    told_still_.clear();
    teller_.Tell("at", fmt::format("frame {} is next, and the last", session_.at()), Place());
    return true;
  }

  /// A person has put this joint where it is known to stand.
  bool Set(const std::string& name, double number) {
    puppet_.SetJoint(name, number);
    const int joint = static_cast<int>(puppet_.JointNamed(name));
    told_still_.erase(joint);
    const char* const unit = EditUnitOf(puppet_.armature(), joint).name;
    teller_.Tell("set",
                 fmt::format("{} stands at {}{}{} now", name, number, *unit ? " " : "", unit));
    return true;
  }

  bool TellPose() {
    json values = json::object();
    const Reading& reading = puppet_.reader().last();
    for (std::size_t j = 0; j < reading.values.size(); ++j)
      values[puppet_.JointName(static_cast<int>(j))] = reading.values[j];
    teller_.Tell("pose", values.dump(), json{{"values", values}}.dump());
    return true;
  }

  void TryToRecord(const Reading& reading) {
    const std::string obstacle = puppet_.Obstacle(reading, false);
    if (!obstacle.empty()) {
      const bool tells = !told_waiting_ && obstacle != kPuppetMoves;
      if (tells) teller_.Tell("waiting", obstacle + "; the frame is taken when that is over");
      told_waiting_ = told_waiting_ || tells;
      return;
    }
    wants_frame_ = told_waiting_ = false;
    const int frame = session_.at();
    session_.Record(reading.values);
    puppet_.SaveCalibration();
    json fields = json::parse(Place());
    fields["frame"] = frame;
    teller_.Tell("recorded", fmt::format("frame {} is recorded", frame), fields.dump());
    TellStill();
    PoseSimulated();
  }

  void TellStill() {
    const auto end = session_.frames().begin() + session_.at();
    const std::vector<std::vector<double>> until(session_.frames().begin(), end);
    const std::vector<int> still = StillJoints(puppet_.armature(), until);
    for (const int joint : still)
      if (told_still_.insert(joint).second)
        teller_.Tell(
            "still-joint", StillWords(puppet_.JointName(joint), session_.at() - 3),
            json{{"joint", puppet_.JointName(joint)}, {"since", session_.at() - 3}}.dump());
  }

  /// The simulated animator poses the next frame.
  void PoseSimulated() {
    if (!puppet_.simulated()) return;
    const double time_s = session_.at() * flags_.options.step / flags_.options.fps;
    puppet_.simulated()->BeginFrame(session_.at());
    puppet_.simulated()->MoveTo(ExampleMotion(puppet_.armature(), time_s));
  }

  const RecordFlags& flags_;
  Puppet& puppet_;
  RecordingSession& session_;
  Teller teller_;
  bool wants_frame_ = false, told_waiting_ = false;
  std::set<int> told_still_;
};

int Record(const RecordFlags& flags) {
  // The port first: one that cannot be used leaves no session behind.
  Puppet puppet(flags.puppet);
  RecordingSession session(puppet.armature(), flags.session, flags.options);
  Recorder recorder(flags, puppet, session);
  LineInput input(STDIN_FILENO);
  bool goes_on = true;
  while (goes_on && !WasInterrupted()) {
    goes_on = recorder.Step(input.Next(0.01));
    if (input.over() && flags.frames == 0) break;
  }
  puppet.SaveCalibration();
  Teller(flags.json)
      .Tell("ended", fmt::format("{} frames in {}", session.frame_count(), flags.session));
  return static_cast<int>(WasInterrupted() ? ExitCode::kInterrupted : ExitCode::kOk);
}

}  // namespace

int RecordCommand(int argc, char** argv) {
  CLI::App app(
      "Records a puppet frame by frame; may be interrupted at any moment, the same command "
      "goes on.",
      "keypose armature record");
  RecordFlags flags;
  AddPuppetFlags(app, flags.puppet);
  app.add_option("--session", flags.session, "folder of the recording; made, or taken up")
      ->required();
  app.add_option("--fps", flags.options.fps, "frames a second of the film")
      ->check(CLI::Range(1.0, 1000.0))
      ->capture_default_str();
  app.add_option("--step", flags.options.step,
                 "frames of the film for each recorded one: 1 on ones, 2 on twos")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  app.add_option("--frames", flags.frames,
                 "record without being asked whenever the puppet rests, until there are so many")
      ->check(CLI::Range(0, 1000000));
  app.add_flag("--json", flags.json, "events as JSON, a line each");
  app.footer(
      "While it runs, type and press Enter: (only Enter) or record | next | back | goto N | "
      "cut | zero JOINT | set JOINT DEGREES | pose | end");
  return RunCommandLine(app, argc, argv, [&] {
    if (flags.frames > 0 && flags.puppet.port != "simulated")
      throw UsageError("--frames needs --port simulated: a real puppet is recorded by Enter");
    return Record(flags);
  });
}

}  // namespace keypose::armature
