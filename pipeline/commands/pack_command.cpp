// `keypose pack`: a project in one file, for another machine or for the shelf.
#include <fmt/format.h>

#include <set>
#include <string>
#include <vector>

#include "pipeline/cache/project_lock.h"
#include "pipeline/commands/keypose_commands.h"
#include "pipeline/disk/zip_writer.h"
#include "pipeline/run/opened_project.h"
#include "pipeline/text/text.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

/// Names below the project, and the size of all.
struct Packed {
  std::vector<std::string> names;
  std::uint64_t bytes = 0;
};

/// Whether a file is, or lies below, one of these; none of them lies within another.
bool IsAmong(const std::string& name, const std::set<std::string>& kept) {
  auto after = kept.upper_bound(name);
  return after != kept.begin() && name.starts_with(*--after);
}

/// Of .keypose only the history, and results that are up to date, as paths below the project. What
/// describes this machine (hashes by inode, the lock, unfinished work) stays here.
std::set<std::string> KeptState(OpenedProject& opened, bool with_cache) {
  if (!with_cache) return {};
  std::set<std::string> kept = {".keypose/steps/", ".keypose/runs/", ".keypose/out.json"};
  const Plan plan(opened.graph(), opened.workshop(), {});
  opened.workshop().hasher.Save();
  for (int i = 0; i < plan.size(); ++i) {
    if (plan[i].artifact)
      kept.insert(
          opened.store().FolderOf(plan[i].fingerprint).lexically_relative(opened.project()) / "");
  }
  return kept;
}

Packed FilesOf(OpenedProject& opened, bool with_cache, const fs::path& archive) {
  const std::set<std::string> kept = KeptState(opened, with_cache);
  Packed packed;
  for (const std::string& name : opened.disk().FilesBelow(opened.project())) {
    if (name.starts_with(".keypose/") && !IsAmong(name, kept)) continue;
    const fs::path file = opened.project() / name;
    if (file == archive) continue;
    packed.names.push_back(name);
    if (const auto stat = opened.disk().Stat(file)) packed.bytes += stat->size;
  }
  return packed;
}

/// What the project reads and the archive cannot hold, because it lies elsewhere.
std::set<std::string> PathsOutside(const OpenedProject& opened) {
  std::set<std::string> outside;
  for (const Step& step : opened.graph().steps)
    for (const PortFlows& port : step.inputs)
      for (const Flow& flow : port.flows) {
        if (flow.kind != Flow::Kind::kSource) continue;
        const fs::path relative =
            (opened.project() / flow.path).lexically_normal().lexically_relative(opened.project());
        if (relative.empty() || *relative.begin() == "..")
          outside.insert(fmt::format("{}: {}", flow.where.Text(), flow.path.string()));
      }
  return outside;
}

}  // namespace

ExitCode PackCommand(const std::string& folder, const std::string& output, bool with_cache) {
  const fs::path project = fs::canonical(FindProject(folder));
  OpenedProject opened(project, {});
  const ProjectLock lock(opened.state(), "keypose pack");
  const std::string name = project.filename().string();
  const fs::path archive =
      fs::absolute(output.empty() ? fs::path(name + ".zip") : fs::path(output)).lexically_normal();
  ZipWriter zip(archive);
  const Packed packed = FilesOf(opened, with_cache, archive);
  fmt::print("packing {} files, {}\n", packed.names.size(), SizeText(packed.bytes));
  std::fflush(stdout);
  for (const std::string& file : packed.names) zip.Add(project / file, name + "/" + file);
  const std::uint64_t bytes = zip.Finish();
  fmt::print("{}: {}. Unpacked anywhere, it is the folder {}/; `keypose run -C {}` goes on there\n",
             archive.string(), SizeText(bytes), name, name);
  for (const std::string& outside : PathsOutside(opened))
    fmt::print("not packed, because it lies outside of the project: {}\n", outside);
  return ExitCode::kOk;
}

}  // namespace keypose::pipeline
