#include "studio/project/result_history.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "core/io/text/files.h"
#include "core/numbers/sha256.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "studio/project/not_found.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;
using pipeline::Artifact;
using pipeline::Step;

namespace {

/// The outputs that show a pose in 3D; the first that there is.
struct ShownOutput {
  const char* rule;
  const char* port;
};
constexpr ShownOutput kShownMeshes[] = {{"fit", "fitted"},
                                        {"register", "registered"},
                                        {"unwrap", "unwrapped"},
                                        {"mend", "mended"},
                                        {"cleanup", "clean"}};
constexpr ShownOutput kShownTextures[] = {{"complete", "completed"}, {"bake", "texture"}};

bool IsPictureName(const fs::path& name) {
  static const std::set<std::string> kPictureEndings = {".png", ".jpg", ".jpeg"};
  return kPictureEndings.contains(LowerExtension(name));
}
bool IsMp4Name(const fs::path& name) { return LowerExtension(name) == ".mp4"; }

/// A report tells of all steps; it is no result of its own.
bool TellsOfOthers(const Step& step) {
  for (const pipeline::PortFlows& port : step.inputs)
    for (const pipeline::Flow& flow : port.flows)
      if (flow.kind == pipeline::Flow::Kind::kRun) return true;
  return false;
}

std::string FingerprintNow(const pipeline::StepPlan& planned) {
  if (planned.artifact) return planned.fingerprint;
  return planned.last ? planned.last->fingerprint : "";
}

std::string Address(const Artifact& artifact, const fs::path& file) {
  return artifact.fingerprint + "/" + file.lexically_relative(artifact.folder).generic_string();
}

/// A folder's results are told apart by their files, of which a list stands in the artifact.
const std::string* HashInside(const pipeline::ArtifactOutput& output, const std::string& inside) {
  if (!output.folder || inside.empty()) return &output.content.hash;
  const auto found = output.content.files.find(inside);
  return found == output.content.files.end() ? nullptr : &found->second;
}

json MeasurementsOf(const std::optional<Artifact>& artifact) {
  if (!artifact) return json::object();
  const fs::path file = artifact->folder / "report.json";
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return json::object();
  const std::string text = ReadFile(file);
  const json report = IsShallowJson(text) ? json::parse(text, nullptr, false) : json();
  if (!report.is_object()) return json::object();
  const auto found = report.find("measurements");
  return found != report.end() && found->is_object() ? *found : json::object();
}

/// Times are of the machine, not of the result.
bool IsFigure(const std::string& key, const json& value) {
  return (value.is_number() || value.is_boolean()) && key.find("seconds") == std::string::npos;
}

json FigureIn(const json& measurements, const std::string& key) {
  const auto found = measurements.find(key);
  return found != measurements.end() && IsFigure(key, *found) ? *found : json();
}

json GoodRange(const pipeline::MeasurementInfo& info) {
  json good = json::object();
  if (info.good_min) good["min"] = *info.good_min;
  if (info.good_max) good["max"] = *info.good_max;
  return good;
}

void AddFigures(const Step& step, const json& before, const json& after, json* figures) {
  std::set<std::string> told;
  const auto add = [&](const std::string& key, const std::string& label, const std::string& unit,
                       const json& good, bool main) {
    const json was = FigureIn(before, key), is = FigureIn(after, key);
    if (!told.insert(key).second || was == is) return;
    figures->push_back({{"step", step.id},
                        {"title", step.info->title},
                        {"key", key},
                        {"label", label},
                        {"unit", unit},
                        {"before", was},
                        {"after", is},
                        {"good", good},
                        {"main", main}});
  };
  for (const pipeline::MeasurementInfo& info : step.info->measurements)
    add(info.key, info.label, info.unit, GoodRange(info), true);
  for (const json* measurements : {&before, &after})
    for (const auto& [key, value] : measurements->items()) add(key, key, "", json::object(), false);
}

/// A step's recipe without what other steps made for it, which they tell of themselves.
pipeline::Recipe OwnPart(pipeline::Recipe recipe, const std::set<std::string>& steps) {
  std::erase_if(recipe.inputs, [&](const pipeline::RecipeInput& input) {
    return steps.contains(input.origin.substr(0, input.origin.rfind('.')));
  });
  return recipe;
}

std::string FingerprintIn(const std::map<std::string, std::string>& values,
                          const std::string& key) {
  const auto found = values.find(key);
  return found == values.end() ? "" : found->second;
}

}  // namespace

fs::path FileAt(pipeline::OpenedProject& project, const std::string& at) {
  const auto slash = std::min(at.find('/'), at.size());
  const std::string fingerprint = at.substr(0, slash);
  std::optional<Artifact> artifact;
  if (pipeline::IsFingerprint(fingerprint)) artifact = project.store().Find(fingerprint);
  if (artifact)
    for (const auto& [port, output] : artifact->outputs) {
      const fs::path base = artifact->Path(port);
      std::vector<fs::path> files = {base};
      if (output.folder) {
        files.clear();
        for (const auto& [name, hash] : output.content.files) files.push_back(base / name);
      }
      for (const fs::path& file : files)
        if (Address(*artifact, file) == at &&
            !project.disk().LeadsOutside(file, project.state() / "cache"))
          return file;
    }
  throw NotFound("of that result this is not there any more");
}

ResultHistory::ResultHistory(Snapshot& snapshot, bool running) : snapshot_(snapshot) {
  for (const pipeline::PoseRule& rule : snapshot.file().poses)
    if (snapshot.HasPose(rule.name)) subjects_.push_back({rule.name, {}, {}});
  subjects_.push_back({"", {}, {}});
  for (const Step& step : snapshot.graph().steps)
    for (ReviewSubject& subject : subjects_)
      if (subject.pose == step.pose && !TellsOfOthers(step)) subject.steps.push_back(&step);
  const auto runs =
      pipeline::PastRuns(snapshot.opened_project().disk(), snapshot.opened_project().state());
  for (ReviewSubject& subject : subjects_) {
    std::set<std::string> seen;
    for (const Moment& moment : MomentsOf(subject, runs, running)) {
      ResultVersion version = VersionOf(subject, moment);
      if (seen.insert(version.id).second) subject.versions.push_back(std::move(version));
    }
  }
}

const ReviewSubject& ResultHistory::Subject(const std::string& pose) const {
  for (const ReviewSubject& subject : subjects_)
    if (subject.pose == pose) return subject;
  throw UsageError(fmt::format("there is no pose '{}'", pose));
}

const ResultVersion& ResultHistory::Version(const std::string& pose, const std::string& id) const {
  for (const ResultVersion& version : Subject(pose).versions)
    if (version.id == id) return version;
  throw NotFound("that result is not on record any more; look again");
}

const std::optional<Artifact>& ResultHistory::ArtifactOf(const std::string& fingerprint) {
  const auto known = artifacts_.find(fingerprint);
  if (known != artifacts_.end()) return known->second;
  std::optional<Artifact> found;
  if (!fingerprint.empty()) found = snapshot_.opened_project().store().Find(fingerprint);
  return artifacts_[fingerprint] = std::move(found);
}

ResultHistory::State ResultHistory::StateNow(std::string* when) const {
  State state;
  double newest = 0;
  for (int i = 0; i < snapshot_.plan().size(); ++i) {
    const pipeline::StepPlan& planned = snapshot_.plan()[i];
    const std::string fingerprint = FingerprintNow(planned);
    if (!fingerprint.empty()) state[snapshot_.graph().steps[i].id] = fingerprint;
    if (planned.last && !planned.last->failed) newest = std::max(newest, planned.last->when);
  }
  *when = newest > 0 ? pipeline::TimeText(newest) : "";
  return state;
}

/// Newest first: what the subject's steps had made at the end of each run, where that was another
/// than before. A run of some steps leaves the others as they were.
std::vector<ResultHistory::Moment> ResultHistory::MomentsOf(
    const ReviewSubject& subject, const std::vector<pipeline::PastRun>& runs, bool running) const {
  std::vector<Moment> moments;
  const auto own = [&](const State& state) {
    std::vector<std::string> fingerprints;
    for (const Step* step : subject.steps) fingerprints.push_back(FingerprintIn(state, step->id));
    return fingerprints;
  };
  const std::vector<std::string> nothing(subject.steps.size());
  const auto add = [&](const State& state, const std::string& when) {
    const auto fingerprints = own(state);
    if (fingerprints == nothing) return;
    if (moments.empty() || own(moments.back().steps) != fingerprints)
      moments.push_back({state, when});
    else
      moments.back().steps = state;
  };
  State state;
  for (const pipeline::PastRun& run : runs) {
    for (const pipeline::PastStep& step : run.steps) state[step.id] = step.fingerprint;
    add(state, run.begin);
  }
  std::string when;
  if (!running) add(StateNow(&when), when);
  if (!moments.empty()) moments.back().now = true;
  std::reverse(moments.begin(), moments.end());
  if (SizeOf(moments) > kMostVersions) moments.resize(kMostVersions);
  return moments;
}

ResultVersion ResultHistory::VersionOf(const ReviewSubject& subject, const Moment& moment) {
  ResultVersion version;
  version.when = moment.when;
  version.now = moment.now;
  version.steps = moment.steps;
  std::map<std::string, std::string> contents;
  for (const Step* step : subject.steps) {
    const std::string fingerprint = FingerprintIn(moment.steps, step->id);
    if (fingerprint.empty()) continue;
    const std::optional<Artifact>& artifact = ArtifactOf(fingerprint);
    if (artifact) {
      AddFiles(*step, *artifact, &version, &contents);
    } else {
      version.gone.push_back(step->id);
      contents[step->id] = fingerprint;
    }
  }
  AddShown(subject, &version);
  for (const auto& [name, hash] : version.shown) contents["shown " + name] = hash;
  version.id = Sha256Of(json(contents).dump()).substr(0, 16);
  return version;
}

void ResultHistory::AddFiles(const Step& step, const Artifact& artifact, ResultVersion* version,
                             std::map<std::string, std::string>* contents) const {
  for (const pipeline::NamedResult& result : step.results) {
    const auto output = artifact.outputs.find(result.port);
    if (output == artifact.outputs.end()) continue;
    const std::string* hash = HashInside(output->second, result.inside);
    if (!hash) continue;
    (*contents)[step.id + " " + result.port + "/" + result.inside] = *hash;
    const fs::path base = artifact.folder / output->second.file;
    const auto add = [&](const fs::path& path, const fs::path& file, const std::string& content) {
      version->files.push_back({path.generic_string(), step.info->title, IsMp4Name(file),
                                Address(artifact, file), content});
    };
    if (output->second.folder && result.inside.empty()) {
      for (const auto& [name, content] : output->second.content.files)
        if (IsMp4Name(name)) add(result.path / name, base / name, content);
    } else if (IsPictureName(result.path) || IsMp4Name(result.path)) {
      add(result.path, result.inside.empty() ? base : base / result.inside, *hash);
    }
  }
}

void ResultHistory::AddShown(const ReviewSubject& subject, ResultVersion* version) {
  const auto find = [&](const auto& outputs, const char* name, std::string* at) {
    for (const auto& [rule, port] : outputs)
      for (const Step* step : subject.steps) {
        if (step->rule != rule) continue;
        const auto& artifact = ArtifactOf(FingerprintIn(version->steps, step->id));
        if (!artifact || !artifact->outputs.contains(port)) continue;
        if (at) *at = Address(*artifact, artifact->Path(port));
        version->shown[name] = artifact->outputs.at(port).content.hash;
        return;
      }
  };
  if (!subject.pose.empty()) find(kShownMeshes, "mesh", &version->mesh);
  if (!version->mesh.empty()) find(kShownTextures, "texture", &version->texture);
  const auto add = [&](bool films) {
    if (!version->shown.empty()) return;
    for (const ResultFile& file : version->files)
      if (file.film == films) version->shown[fs::path(file.path).filename().string()] = file.hash;
  };
  add(true);
  if (version->shown.empty())
    find(std::initializer_list<ShownOutput>{{"interpolate", "frames"}}, "frames", nullptr);
  add(false);
}

std::vector<const Step*> ResultHistory::WithNeeds(const ReviewSubject& subject) const {
  const std::vector<Step>& steps = snapshot_.graph().steps;
  std::set<int> wanted;
  std::vector<int> above;
  for (const Step* step : subject.steps) above.push_back(static_cast<int>(step - steps.data()));
  while (!above.empty()) {
    const int one = above.back();
    above.pop_back();
    if (!wanted.insert(one).second) continue;
    above.insert(above.end(), steps[one].needs.begin(), steps[one].needs.end());
  }
  std::vector<const Step*> all;
  for (const int i : wanted) all.push_back(&steps[i]);
  return all;
}

json ResultHistory::CompareJson(const std::string& pose, const std::string& before,
                                const std::string& after) {
  const ReviewSubject& subject = Subject(pose);
  const ResultVersion &was = Version(pose, before), &is = Version(pose, after);
  std::set<std::string> ids;
  for (const Step& step : snapshot_.graph().steps) ids.insert(step.id);
  json changes = json::array(), unknown = json::array(), figures = json::array();
  for (const Step* step : WithNeeds(subject)) {
    const std::string old = FingerprintIn(was.steps, step->id),
                      now = FingerprintIn(is.steps, step->id);
    if (old.empty() || now.empty() || old == now) continue;
    const auto first = ArtifactOf(old), second = ArtifactOf(now);
    if (!first || !second) {
      unknown.push_back(step->id);
      continue;
    }
    for (const std::string& text :
         pipeline::Differences(OwnPart(first->recipe, ids), OwnPart(second->recipe, ids)))
      changes.push_back({{"step", step->id}, {"title", step->info->title}, {"text", text}});
    if (step->pose == pose)
      AddFigures(*step, MeasurementsOf(first), MeasurementsOf(second), &figures);
  }
  return {{"changes", changes}, {"unknown", unknown}, {"figures", figures}};
}

}  // namespace keypose::studio
