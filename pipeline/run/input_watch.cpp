#include "pipeline/run/input_watch.h"

#include <set>

#include "core/values/errors.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

/// A missing file gets no stamp.
void Add(const Disk& disk, const fs::path& path, Stamps* stamps) {
  if (const auto stat = disk.Stat(path)) (*stamps)[path.generic_string()] = *stat;
}

/// The folder's own time changes when files are added or removed.
void AddAllBelow(const Disk& disk, const fs::path& path, Stamps* stamps) {
  Add(disk, path, stamps);
  const auto stat = disk.Stat(path);
  if (!stat || !stat->folder) return;
  std::set<fs::path> folders;
  for (const std::string& name : disk.FilesBelow(path)) {
    if (!CountsAsContent(name)) continue;
    Add(disk, path / name, stamps);
    for (fs::path folder = fs::path(name).parent_path(); !folder.empty();
         folder = folder.parent_path())
      folders.insert(folder);
  }
  for (const fs::path& folder : folders) Add(disk, path / folder, stamps);
}

/// The first path at which the two differ.
std::string Difference(const Stamps& before, const Stamps& now) {
  for (const auto& [name, stat] : before) {
    const auto it = now.find(name);
    if (it == now.end()) return name + " went away";
    if (!(it->second == stat) && !stat.folder) return name + " was changed";
  }
  for (const auto& [name, stat] : now)
    if (!before.contains(name)) return name + " came";
  for (const auto& [name, stat] : before)
    if (!(now.at(name) == stat)) return "files came to or went from " + name;
  return "";
}

}  // namespace

Stamps InputWatch::Look(int step) const {
  const Step& what = plan_.graph().steps[step];
  Stamps stamps;
  for (const PortFlows& port : what.inputs)
    for (const Flow& flow : port.flows)
      if (flow.kind == Flow::Kind::kSource)
        AddAllBelow(workshop_.disk, plan_.SourceOf(flow), &stamps);
  for (const auto& [program, stat] : what.info->programs) Add(workshop_.disk, program, &stamps);
  return stamps;
}

std::string InputWatch::Changed(int step, const Stamps& before) const {
  const Step& what = plan_.graph().steps[step];
  if (std::string difference = Difference(before, Look(step)); !difference.empty())
    return difference;
  for (const auto& [program, stat] : what.info->programs)
    if (workshop_.disk.Stat(program) != stat) return program + " was replaced";
  const Recipe& recipe = plan_[step].recipe;
  std::size_t input = 0;
  for (const PortFlows& port : what.inputs)
    for (const Flow& flow : port.flows) {
      const RecipeInput& planned = recipe.inputs.at(input++);
      if (flow.kind == Flow::Kind::kSource &&
          workshop_.hasher.Of(plan_.SourceOf(flow)).hash != planned.content.hash)
        return plan_.SourceOf(flow).string() + " was changed";
    }
  for (const int need : what.needs) {
    std::string damage = "it went away";
    if (!workshop_.store.Find(plan_[need].fingerprint, &damage))
      return "the artifact of " + plan_.graph().steps[need].id + " was damaged (" + damage + ")";
  }
  return "";
}

}  // namespace keypose::pipeline
