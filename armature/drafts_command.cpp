// `keypose armature drafts`: answers a page what a recorded take would be with some changes, many
// times a second, as a person pulls at it. It keeps nothing.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "armature/armature_commands.h"
#include "armature/live/joint_timing.h"
#include "armature/live/page_stream.h"
#include "armature/live/puppet_files.h"
#include "armature/puppet.h"
#include "armature/recording/curve_edits.h"
#include "core/io/text/files.h"
#include "core/io/text/line_input.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::armature {
namespace {

using nlohmann::json;

/// What a page can play.
constexpr int kMostFilmFrames = 100000;

struct DraftFlags {
  std::string description, chains, skeleton, curves;
  PuppetChoices choices;
};

/// Null stands for a limit that there is not.
json LimitJson(double value) { return std::isfinite(value) ? json(value) : json(); }

/// The curves in the units in which edits are written; nine digits are enough to look at.
/// @param film  how many frames of the film follow the recorded ones
std::string TakeText(const Armature& armature, const JointCurves& curves, Eigen::Index film) {
  std::string text =
      fmt::format(R"({{"fps":{},"step":{},"film":{},"joints":[)", curves.fps, curves.step, film);
  for (int j = 0; j < SizeOf(armature.joints); ++j) {
    const auto node = static_cast<std::size_t>(armature.joints[static_cast<std::size_t>(j)]);
    const EditUnit unit = EditUnitOf(armature, j);
    const json head = {{"name", armature.nodes[node].name},
                       {"unit", unit.name},
                       {"low", LimitJson(armature.nodes[node].low / unit.size)},
                       {"high", LimitJson(armature.nodes[node].high / unit.size)}};
    text += (j ? "," : "") + head.dump(-1, ' ', false, json::error_handler_t::replace);
    text.back() = ',';
    text += R"("values":[)";
    for (int f = 0; f < curves.frame_count(); ++f)
      text += fmt::format("{}{:.9g}", f ? "," : "", curves.values(f, j) / unit.size);
    text += "]}";
  }
  return text + "]}";
}

/// @param values  frames x joints
std::string PosesOf(const PuppetParts& parts, const Eigen::MatrixXd& values) {
  std::vector<std::vector<double>> frames;
  for (Eigen::Index f = 0; f < values.rows(); ++f) {
    const Eigen::RowVectorXd row = values.row(f);
    frames.emplace_back(row.data(), row.data() + row.size());
  }
  return PoseBytes(parts, frames);
}

/// Frame after frame, in the units in which edits are written (float32, little-endian).
std::string ValueBytes(const Armature& armature, const Eigen::MatrixXd& values) {
  if (values.rows() == 0) return {};  // columns of nothing have no address
  Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> numbers(values.rows(),
                                                                                values.cols());
  for (Eigen::Index j = 0; j < values.cols(); ++j) {
    const double size = EditUnitOf(armature, static_cast<int>(j)).size;
    numbers.col(j) = (values.col(j) / size).cast<float>();
  }
  return {reinterpret_cast<const char*>(numbers.data()),
          static_cast<std::size_t>(numbers.size()) * sizeof(float)};
}

/// The film as `bake` would make it of these curves; empty if nobody asks.
Eigen::MatrixXd FilmOf(const JointCurves& curves, const std::string& between) {
  if (between.empty()) return Eigen::MatrixXd(0, curves.values.cols());
  if (static_cast<double>(curves.frame_count()) * curves.step > kMostFilmFrames)
    throw InputError(fmt::format("{} recorded frames of {} film frames each are too many to show",
                                 curves.frame_count(), curves.step));
  return FilmValues(curves.values, curves.step, BetweenNamed(between));
}

/// Answers one question after another; the curves are read each time, as more may be recorded.
class Drafter {
 public:
  explicit Drafter(const DraftFlags& flags)
      : curves_(flags.curves),
        parts_(LoadPuppet({flags.description, flags.chains, flags.skeleton, {}, {}}, flags.choices)
                   .parts) {}

  json Answer(const std::string& line) const {
    try {
      const json question = json::parse(line);
      const std::string edits = question.at("edits"), to = question.at("to");
      const JointCurves curves = Changed(edits);
      const Eigen::MatrixXd film = FilmOf(curves, question.value("between", ""));
      std::string take = TakeText(parts_.armature, curves, film.rows());
      // The bones begin at a multiple of four.
      take.append(3 - take.size() % 4, ' ');
      WriteFile(to, take + '\n' + PosesOf(parts_, curves.values) + PosesOf(parts_, film) +
                        ValueBytes(parts_.armature, film));
      return {{"frames", curves.frame_count()}};
    } catch (const json::exception& error) {
      return {{"error", std::string("this is no question: ") + error.what()}};
    } catch (const Error& error) {
      return {{"error", error.what()}};
    }
  }

 private:
  JointCurves Changed(const std::string& edits) const {
    const JointCurves curves =
        ParseCurvesJson(ReadFile(curves_), PrintableName(curves_), parts_.armature);
    if (curves.frame_count() == 0)
      throw InputError("the take " + PrintableName(curves_) + " has no frame yet; record some");
    if (edits.empty()) return curves;
    return EditedCurves(
        parts_.armature, curves,
        ParseCurveEdits(ReadFile(edits), PrintableName(std::filesystem::path(edits).filename()),
                        parts_.armature));
  }

  const std::filesystem::path curves_;
  const PuppetParts parts_;
};

int Draft(const DraftFlags& flags) {
  const Drafter drafter(flags);
  LineInput input(STDIN_FILENO);
  while (!WasInterrupted() && !input.over()) {
    const std::optional<std::string> line = input.Next(0.2);
    if (!line) continue;
    fmt::print("{}\n", drafter.Answer(*line).dump(-1, ' ', false, json::error_handler_t::replace));
    std::fflush(stdout);
  }
  return static_cast<int>(WasInterrupted() ? ExitCode::kInterrupted : ExitCode::kOk);
}

}  // namespace

int DraftsCommand(int argc, char** argv) {
  CLI::App app("Answers what a recorded take would be with some changes; keeps nothing.",
               "keypose armature drafts");
  DraftFlags flags;
  app.add_option("--description", flags.description, "the armature's description file")->required();
  app.add_option("--chains", flags.chains, "the file of anchors and chains")->required();
  app.add_option("--skeleton", flags.skeleton, "the computer skeleton (.bvh)");
  app.add_option("--armature_up", flags.choices.armature_up, "y or z, in the description")
      ->check(CLI::IsMember({"y", "z"}));
  app.add_option("--skeleton_up", flags.choices.skeleton_up, "y or z, in the skeleton's file")
      ->check(CLI::IsMember({"y", "z"}));
  app.add_option("--curves", flags.curves, "recorded curves (curves.json of a session)")
      ->required();
  app.footer(
      "Each line that it reads is a question: {\"edits\": FILE of `armature edit`, or \"\", "
      "\"to\": FILE}, and \"between\": hold, linear or smooth if wanted. It writes a line of JSON "
      "with the curves to the file, then the bones in each frame; with between also those in each "
      "frame of the film that `bake` would make, and the joints' values there. It answers "
      "{\"frames\": N} or {\"error\": WORDS}.");
  return RunCommandLine(app, argc, argv, [&] { return Draft(flags); });
}

}  // namespace keypose::armature
