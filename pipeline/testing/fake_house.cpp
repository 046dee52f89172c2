#include "pipeline/testing/fake_house.h"

#include <algorithm>

#include "core/io/text/files.h"
#include "core/testing/paths.h"
#include "pipeline/graph/build_graph.h"
#include "pipeline/graph/pipeline_overlay.h"

namespace keypose::pipeline {
namespace {

using nlohmann::json;

json Port(const std::string& name, const std::string& kind, const std::string& file = "") {
  return {{"name", name}, {"kind", kind}, {"file", file}};
}
json Many(json port) {
  port["repeatable"] = true;
  return port;
}
json Optional(json port) {
  port["optional"] = true;
  return port;
}
json Option(const std::string& name, const std::string& type, const json& value) {
  return {{"name", name},   {"type", type},   {"default", value},        {"unit", ""},
          {"min", nullptr}, {"max", nullptr}, {"choices", json::array()}};
}

json Describe(const std::string& stage, const json& inputs, const json& outputs,
              const json& options) {
  return {{"schema", 1},
          {"stage", stage},
          {"version", "1"},
          {"summary", "a test"},
          {"inputs", inputs},
          {"outputs", outputs},
          {"options", options},
          {"tools", json::array()},
          {"resources", {{"cores", 0}, {"memory_bytes", 1000}}}};
}

std::string ReadAll(const MemoryDisk& disk, const std::filesystem::path& path) {
  if (!disk.Stat(path)->folder) return disk.Read(path);
  std::string text;
  for (const std::string& name : disk.FilesBelow(path))
    text += name + "=" + disk.Read(path / name) + ";";
  return text;
}

/// Its output contains the options and inputs, so that any difference in them is visible.
int Concatenate(const FakeCall& call, MemoryDisk& disk, const std::string& output,
                const std::vector<std::string>& ports) {
  std::string text = call.Flag("tone") + call.Flag("depth");
  for (const std::string& port : ports) {
    if (!call.flags.contains(port)) continue;
    text += "(" + port;
    for (const std::string& path : call.flags.at(port)) text += " " + ReadAll(disk, path);
    text += ")";
  }
  disk.Write(call.Flag(output), text);
  disk.Write(call.Flag("report"), "{}");
  return 0;
}

int Shoot(const FakeCall& call, MemoryDisk& disk) {
  const std::filesystem::path photos = call.Flag("photos"), images = call.Flag("images");
  disk.MakeFolder(images);
  for (const std::string& name : disk.FilesBelow(photos))
    disk.Write(images / name, disk.Read(photos / name) + call.Flag("tone"));
  return 0;
}

int Solve(const FakeCall& call, MemoryDisk& disk) {
  const std::filesystem::path images = call.Flag("images");
  std::string text = call.Flag("depth");
  for (const std::string& name : disk.FilesBelow(images))
    text += disk.Read(images / name).substr(0, 1);
  disk.Write(call.Flag("model"), text);
  return 0;
}

int Tell(const FakeCall& call, MemoryDisk& disk) {
  const json run = json::parse(disk.Read(std::filesystem::path(call.Flag("run")) / "run.json"));
  std::string text;
  for (const json& step : run.at("steps")) text += step.at("id").get<std::string>() + " ";
  disk.Write(std::filesystem::path(call.Flag("report_page")) / "index.html", text);
  return 0;
}

/// Of the default pipeline.
const std::vector<SourceRule>& ShippedSources(ProjectKind kind) {
  const auto read = [](const char* name) {
    return ParsePipelineFile(ReadFile(SourceFolder() + "/" + name), name).sources;
  };
  static const std::vector<SourceRule> kPoses = read("pipeline.yaml"),
                                       kPerformance = read("performance.yaml");
  return kind == ProjectKind::kPoses ? kPoses : kPerformance;
}

class Notes final : public RunObserver {
 public:
  void Begin(const Forecast& all) override { forecast = all; }
  void Started(const std::string& step, const std::vector<std::string>&, int) override {
    ran.push_back(step);
  }
  void Progressed(const std::string&, double, const std::string&) override {}
  void Finished(const std::string&, const std::string&, double) override {}
  void Note(const std::string& line) override { lines.push_back(line); }
  void End(const Ending& all) override { ending = all; }
  std::vector<std::string> ran, lines;
  Forecast forecast;
  Ending ending;
};

}  // namespace

const char* const kFakePipeline = R"(steps:
  shoot:
    stage: shoot
    for: pose
    inputs: {photos: $photos}
  solve:
    stage: solve
    for: pose
    inputs: {images: shoot.images}
  shape:
    stage: shape
    for: pose
    inputs: {model: solve.model}
    out: {mesh: "{pose}/mesh.txt"}
  match:
    stage: match
    for: pair
    inputs: {source: shape.mesh@template, target: shape.mesh, landmarks: $landmarks, stiffness: $stiffness}
  blend:
    stage: blend
    for: animation
    inputs: {keys: {template: shape.mesh, others: match.matched}, timeline: $timeline}
    out: {frames: animation}
  tell:
    stage: tell
    for: project
    inputs: {run: $run}
    out: {report_page: report}
)";

struct FakeHouse::Parts {
  Parts(FakeHouse& house, const std::vector<std::string>& set)
      : catalog(house.disk, house.processes, house.project / ".keypose/stages.json"),
        hasher(house.disk, house.project / ".keypose/hashes.json", house.project),
        store(house.disk, house.project / ".keypose"),
        records(house.disk, house.project / ".keypose"),
        workshop{house.disk, hasher, store, records, house.project} {
    std::vector<Override> overrides;
    for (const std::string& text : set) overrides.push_back(ParseOverride(text));
    const PipelineFile own =
        ParsePipelineFile(house.disk.Read(house.project / "pipeline.yaml"), "pipeline.yaml");
    PipelineFile defaults = ParsePipelineFile(house.default_pipeline, "default.yaml");
    if (defaults.sources.empty()) defaults.sources = ShippedSources(own.kind);
    graph =
        BuildGraph(Overlay(defaults, own), overrides, {house.project, "/bin"}, house.disk, catalog);
  }
  StageCatalog catalog;
  ContentHasher hasher;
  ArtifactStore store;
  Records records;
  Workshop workshop;
  Graph graph;
};

FakeHouse::FakeHouse() {
  const auto add = [&](const std::string& stage, const json& inputs, const json& outputs,
                       const json& options, auto run) {
    disk.Write("/bin/keypose-" + stage, stage);
    processes.stages["/bin/keypose-" + stage] = {Describe(stage, inputs, outputs, options), run};
  };
  const json depth = Option("depth", "int", 9), tone = Option("tone", "string", "plain");
  const auto list = [](auto... items) { return json::array({items...}); };
  add("shoot", list(Port("photos", "folder")), list(Port("images", "folder", "images")), list(tone),
      Shoot);
  add("solve", list(Port("images", "folder")), list(Port("model", "file", "model.txt")),
      list(depth, Option("speed", "double", 0.5)), Solve);
  add("shape", list(Port("model", "file")), list(Port("mesh", "file", "mesh.txt")), list(depth),
      [](const FakeCall& call, MemoryDisk& d) { return Concatenate(call, d, "mesh", {"model"}); });
  add("match",
      list(Port("source", "file"), Port("target", "file"),
           Many(Optional(Port("landmarks", "file"))), Optional(Port("stiffness", "file"))),
      list(Port("matched", "file", "matched.txt")), json::array(),
      [](const FakeCall& call, MemoryDisk& d) {
        return Concatenate(call, d, "matched", {"source", "target", "landmarks", "stiffness"});
      });
  add("bend",
      list(Port("template", "file"), Port("images", "folder"), Optional(Port("rig", "file")),
           Many(Optional(Port("landmarks", "file")))),
      list(Port("bent", "file", "bent.txt"), Port("model", "file", "model.txt")), list(depth),
      [](const FakeCall& call, MemoryDisk& d) {
        d.Write(call.Flag("model"), "found");
        return Concatenate(call, d, "bent", {"template", "images", "rig"});
      });
  add("blend", list(Many(Port("keys", "file")), Optional(Port("timeline", "file"))),
      list(Port("frames", "folder", "frames")), json::array(),
      [](const FakeCall& call, MemoryDisk& d) {
        const auto& keys = call.flags.at("keys");
        const std::filesystem::path frames = call.Flag("frames");
        for (std::size_t i = 0; i < keys.size(); ++i)
          d.Write(frames / ("frame_" + std::to_string(i)), d.Read(keys[i]));
        if (call.flags.contains("timeline"))
          d.Write(frames / "timeline", d.Read(call.Flag("timeline")));
        return 0;
      });
  add("tell", list(Port("run", "folder")), list(Port("report_page", "folder", "report")),
      json::array(), Tell);
  WriteProject("poses: {rest: photos/rest, bent: photos/bent}\ntemplate: rest\n");
  for (const std::string pose : {"rest", "bent"}) {
    for (int i = 0; i < 3; ++i)
      disk.Write(project / "photos" / pose / ("IMG_" + std::to_string(i) + ".jpg"),
                 pose.substr(0, 1) + " picture " + std::to_string(i));
  }
}

FakeHouse::~FakeHouse() = default;

std::unique_ptr<FakeHouse::Parts> FakeHouse::Open(const std::vector<std::string>& set) {
  return std::make_unique<Parts>(*this, set);
}

FakeHouse::Outcome FakeHouse::Run(const Selection& selection, const std::vector<std::string>& set,
                                  int cores) {
  const auto parts = Open(set);
  Plan plan(parts->graph, parts->workshop, selection);
  ResultsFolder results(disk, project / "out", project / ".keypose/out.json");
  Notes notes;
  RunRecord record;
  record.name = "run" + std::to_string(1000 + runs_++);
  Outcome outcome;
  outcome.result =
      Builder(plan, parts->workshop, processes, clock, results, notes, {cores, 0}).Run(record);
  outcome.ran = notes.ran;
  std::sort(outcome.ran.begin(), outcome.ran.end());
  outcome.notes = notes.lines;
  outcome.forecast = notes.forecast;
  outcome.ending = notes.ending;
  clock.Advance(100);
  return outcome;
}

FakeHouse::View FakeHouse::Look(const Selection& selection, const std::vector<std::string>& set) {
  opened_.push_back(Open(set));
  View view;
  view.graph = std::make_unique<Graph>(opened_.back()->graph);
  view.plan = std::make_unique<Plan>(*view.graph, opened_.back()->workshop, selection);
  return view;
}

std::string FakeHouse::View::Reasons(const std::string& id) const {
  std::string text;
  for (const std::string& reason : Step(id).reasons) text += reason + "\n";
  return text;
}

void FakeHouse::MoveProject(const std::filesystem::path& to) {
  disk.Move(project, to);
  project = to;
  // `cp -r` to another machine changes all times.
  for (const std::string& name : disk.FilesBelow(project)) disk.Touch(project / name);
}

}  // namespace keypose::pipeline
