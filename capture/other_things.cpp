#include "capture/other_things.h"

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <numeric>

#include "capture/board/print_seen.h"
#include "capture/pictures/strangers.h"
#include "core/values/errors.h"
#include "core/values/figure_strokes.h"
#include "core/values/size_of.h"

namespace keypose::capture {
namespace {

using Members = std::vector<std::size_t>;
using NameList = std::vector<std::string>;

constexpr std::size_t kFewestOfAPlacement =
    4;                              // photographs of a placement: of fewer, none is the odd one
constexpr std::size_t kOneOf = 4;   // strangers: at most one of so many
constexpr std::size_t kAThing = 3;  // photographs: fewer are no second figure's set

/// A person's word on what the figure is, in the photographs that have it.
std::vector<char> SaidBySomebody(const PhotographImport& import, const std::string& figure) {
  std::vector<char> said(import.photographs.size(), 0);
  std::vector<std::string> names;
  for (const Photograph& photograph : import.photographs) names.push_back(photograph.name);
  for (const FigureStroke& stroke : ParseFigureStrokes(figure))
    if (const int i = IndexOfPicture(stroke, names); i >= 0) said[static_cast<std::size_t>(i)] = 1;
  for (std::size_t i = 0; i < said.size(); ++i)
    if (!import.user_masks[i].empty()) said[i] = 1;
  return said;
}

NameList NamesOf(const PhotographImport& import, const Members& members) {
  NameList names;
  for (const std::size_t i : members) names.push_back(import.photographs[i].name);
  return names;
}

/// The things that the photographs of a placement show, by index in the import; those that a person
/// said something of are one thing, with the largest.
std::vector<Members> ThingsIn(const Members& members, const std::vector<Image8>& pictures,
                              const std::vector<ColourSketch>& sketches,
                              const std::vector<Image8>& prints, const std::vector<char>& said,
                              Progress* progress) {
  const auto groups = ThingsShown(pictures, sketches, prints, progress);
  std::vector<Members> things;
  for (const auto& group : groups) {
    Members thing;
    for (const std::size_t k : group) thing.push_back(members[k]);
    const bool known = std::any_of(thing.begin(), thing.end(), [&](auto i) { return said[i]; });
    if (known && !things.empty())
      things[0].insert(things[0].end(), thing.begin(), thing.end());
    else
      things.push_back(std::move(thing));
  }
  std::sort(things[0].begin(), things[0].end());
  return things;
}

/// @throws InputError  sets of several figures are mixed
void RefuseMixed(const PhotographImport& import, const std::vector<Members>& things,
                 std::size_t photographs) {
  std::string groups;
  std::size_t in_groups = 0, count = 0;
  for (const Members& thing : things) {
    if (thing.size() < kAThing) continue;
    in_groups += thing.size();
    groups += (count++ ? "; " : "") + std::to_string(thing.size()) +
              " show one: " + JoinNames(NamesOf(import, thing));
  }
  // Scattered photographs, such as a few from far apart, do not tell.
  if (count < 2 || kOneOf * in_groups < (kOneOf - 1) * photographs) return;
  throw InputError("capture: " + import.folder.string() + " has photographs of " +
                   std::to_string(count) + " different things: " + groups +
                   ". Keep those of one figure and move the others to a folder of their own; if "
                   "they are one figure, give --other_things keep");
}

void TellOfDoubles(StageContext& stage, const PhotographImport& import, const Members& members,
                   const std::vector<Image8>& pictures, const std::vector<ColourSketch>& sketches) {
  std::vector<std::string> doubles;
  for (const auto& [first, second] : SameViews(pictures, sketches))
    doubles.push_back(import.photographs[members[second]].name + " = " +
                      import.photographs[members[first]].name);
  if (doubles.empty()) return;
  stage.ReportJson("same_views", nlohmann::json(doubles).dump());
  stage.Warn("these photographs show the same view twice: " + JoinNames(doubles) +
             "; it was saved again, or the table was not turned: delete one of each");
}

template <class List>
void KeepMarked(const std::vector<char>& kept, List* list) {
  if (list->size() != kept.size()) return;  // not filled yet
  std::size_t to = 0;
  for (std::size_t i = 0; i < kept.size(); ++i)
    if (kept[i]) {
      if (to != i) (*list)[to] = std::move((*list)[i]);
      ++to;
    }
  list->resize(to);
}

void KeepMarked(const std::vector<char>& kept, PhotographImport* import) {
  std::size_t begin = 0;
  for (PhotographGroup& group : import->groups) {
    const std::vector<char> of_group(
        kept.begin() + static_cast<std::ptrdiff_t>(begin),
        kept.begin() + static_cast<std::ptrdiff_t>(begin + group.files.size()));
    begin += group.files.size();
    KeepMarked(of_group, &group.files);
  }
  KeepMarked(kept, &import->files);
  KeepMarked(kept, &import->photographs);
  KeepMarked(kept, &import->quarter_turns);
  KeepMarked(kept, &import->factors);
  KeepMarked(kept, &import->small);
  KeepMarked(kept, &import->user_masks);
  KeepMarked(kept, &import->mask_ways);
  KeepMarked(kept, &import->board_corners);
  KeepMarked(kept, &import->boards);
  import->sizes = GroupedBySize(import->photographs, import->quarter_turns);
}

/// The photographs of one placement that show another thing than most of it.
Members OthersIn(StageContext& stage, const PhotographImport& import, const Members& members,
                 const std::vector<char>& said, const CaptureOptions& options) {
  std::vector<Image8> pictures, prints;
  std::vector<ColourSketch> sketches;
  for (const std::size_t i : members) {
    pictures.push_back(import.small[i]);
    prints.push_back(PrintSeen(import.boards[i]));
    sketches.push_back(SketchOf(pictures.back(), prints.back()));
  }
  TellOfDoubles(stage, import, members, pictures, sketches);
  if (members.size() < kFewestOfAPlacement) return {};
  const std::vector<Members> things =
      ThingsIn(members, pictures, sketches, prints, said, stage.progress());
  if (kOneOf * things[0].size() < (kOneOf - 1) * members.size()) {
    if (options.KeepsOtherThings()) return {};
    RefuseMixed(import, things, members.size());
    return {};
  }
  Members others;
  for (std::size_t t = 1; t < things.size(); ++t)
    others.insert(others.end(), things[t].begin(), things[t].end());
  std::sort(others.begin(), others.end());
  return others;
}

}  // namespace

std::vector<SetAside> SetOtherThingsAside(StageContext& stage, PhotographImport* import,
                                          const CaptureOptions& options) {
  const std::vector<char> said = SaidBySomebody(*import, options.figure);
  Members others;
  std::size_t begin = 0;
  for (const PhotographGroup& group : import->groups) {
    Members members(group.files.size());
    std::iota(members.begin(), members.end(), begin);
    begin += members.size();
    const Members here = OthersIn(stage, *import, members, said, options);
    others.insert(others.end(), here.begin(), here.end());
  }
  const NameList names = NamesOf(*import, others);
  const bool keeps = options.KeepsOtherThings();
  stage.ReportJson("other_things", nlohmann::json(keeps ? NameList{} : names).dump());
  if (others.empty()) return {};
  const std::string told =
      "show another thing than the others, or the set without the figure: " + JoinNames(names);
  if (keeps) {
    stage.Warn("these photographs " + told + "; they were kept, as other_things says");
    return {};
  }
  std::vector<SetAside> aside;
  std::vector<char> kept(import->files.size(), 1);
  for (std::size_t k = 0; k < others.size(); ++k) {
    kept[others[k]] = 0;
    aside.push_back({names[k],
                     "it shows another thing than the others, or the set without the figure",
                     std::move(import->small[others[k]])});
  }
  KeepMarked(kept, import);
  if (SizeOf(import->files) < options.min_images)
    throw InputError("capture: only " + std::to_string(import->files.size()) +
                     " photographs show one thing, and at least " +
                     std::to_string(options.min_images) + " are needed; these " + told +
                     "; if they are one figure, set other_things: keep");
  stage.Warn("these photographs " + told +
             "; they were left out: take them out of the folder, or, if they do show the figure, "
             "set other_things: keep");
  return aside;
}

}  // namespace keypose::capture
