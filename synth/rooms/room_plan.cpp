#include "synth/rooms/room_plan.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "core/values/angles.h"
#include "core/values/errors.h"
#include "synth/worlds/noise.h"

namespace keypose::synth {
namespace {

constexpr std::array<std::pair<RoomKind, const char*>, 7> kKinds = {
    {{RoomKind::kWalk, "walk"},
     {RoomKind::kMat, "mat"},
     {RoomKind::kMatHand, "mat-hand"},
     {RoomKind::kBoth, "both"},
     {RoomKind::kOneSide, "one-side"},
     {RoomKind::kTrunk, "trunk"},
     {RoomKind::kRelief, "relief"}}};

/// Free-standing kinds in turn: of 24 seeds 6 walk, 6 turn on a tripod, 4 by hand, 5 do both, 3 see
/// one side.
RoomKind KindOfSeed(std::uint64_t seed) {
  constexpr RoomKind kTurns[24] = {
      RoomKind::kWalk,    RoomKind::kMat,  RoomKind::kMatHand, RoomKind::kBoth,
      RoomKind::kWalk,    RoomKind::kMat,  RoomKind::kBoth,    RoomKind::kOneSide,
      RoomKind::kMatHand, RoomKind::kMat,  RoomKind::kWalk,    RoomKind::kBoth,
      RoomKind::kMat,     RoomKind::kWalk, RoomKind::kMatHand, RoomKind::kOneSide,
      RoomKind::kBoth,    RoomKind::kMat,  RoomKind::kWalk,    RoomKind::kMatHand,
      RoomKind::kMat,     RoomKind::kBoth, RoomKind::kWalk,    RoomKind::kOneSide};
  return kTurns[(seed + 23) % 24];
}

int PhotographsOf(RoomKind kind, std::uint64_t seed) {
  if (kind == RoomKind::kOneSide) return 9 + static_cast<int>(seed % 4);
  if (kind == RoomKind::kTrunk || kind == RoomKind::kRelief) return 18;
  return 36;
}

std::string SecondOfSeed(RoomKind kind, std::uint64_t seed) {
  if (kind == RoomKind::kTrunk || kind == RoomKind::kRelief) return "none";
  if (seed % 4 == 1) return "touching";
  return seed % 2 == 0 || kind == RoomKind::kMat ? "none" : "apart";
}

std::string SupportOf(RoomKind kind, Random& random) {
  const bool first = random.Uniform() < 0.5;
  switch (kind) {
    case RoomKind::kWalk:
      return first ? "cloth" : "book";
    case RoomKind::kOneSide:
      return first ? "book" : "cloth";
    case RoomKind::kTrunk:
      return "trunk";
    case RoomKind::kRelief:
      return "wall";
    default:
      return first ? "mat" : "disc";
  }
}

/// A lamp in front of what a wall or trunk stands behind; anywhere around a table in a room.
RoomLight LightOf(RoomKind kind, Random& random) {
  RoomLight light;
  light.azimuth_rad =
      kind == RoomKind::kWalk ? random.Uniform(0, 2 * kPi) : -kPi / 2 + random.Uniform(-1.0, 1.0);
  light.elevation_rad = random.Uniform(45, 62) * kDegree;
  light.ambient = random.Uniform(0.38, 0.55);
  light.lamp = random.Uniform(0.5, 0.75);
  return light;
}

void ChooseFigure(RoomPlan& plan, Random& random) {
  static const char* const kPoses[] = {"rest", "bent", "wave", "bow", "twist", "limbs"};
  static const char* const kColumnPoses[] = {"rest", "bent", "twist"};
  plan.figure_seed = plan.seed * 10 + 3;
  plan.character = plan.free_standing() && plan.seed % 7 == 6 ? "columns" : "creature";
  plan.pose = plan.character == "columns" ? kColumnPoses[random.Below(3)] : kPoses[random.Below(6)];
  if (plan.texture.empty()) plan.texture = plan.seed % 8 == 6 ? "weak" : "rich";
}

}  // namespace

RoomKind RoomKindNamed(const std::string& name) {
  std::string known;
  for (const auto& [kind, text] : kKinds) {
    if (name == text) return kind;
    known += (known.empty() ? "" : ", ") + std::string(text);
  }
  throw UsageError("synth: there is no room of the kind '" + name + "'; there are " + known);
}

std::string NameOf(RoomKind kind) {
  for (const auto& [each, text] : kKinds)
    if (each == kind) return text;
  return "";
}

std::vector<std::string> RoomOptions::Problems() const {
  std::vector<std::string> problems;
  const auto require = [&](bool good, const char* text) {
    if (!good) problems.emplace_back(text);
  };
  const auto among = [](const std::string& text, std::initializer_list<const char*> known) {
    return text.empty() || std::find(known.begin(), known.end(), text) != known.end();
  };
  require(photographs == 0 || (photographs >= 4 && photographs <= 400),
          "--photographs must be from 4 to 400");
  require(width >= 64 && height >= 64 && width <= 10000 && height <= 10000,
          "a photograph's sides must be from 64 to 10000 pixels");
  require(among(second, {"none", "apart", "touching"}), "--second can be none, apart or touching");
  require(among(exif, {"yes", "no"}), "--exif can be yes or no");
  require(among(texture, {"rich", "weak"}), "--texture can be rich or weak");
  require(hands <= 400 && (photographs == 0 || hands <= photographs),
          "--hands must be at most the number of photographs");
  require(lenses < 0 || lenses == 1 || lenses == 2, "--lenses can be 1 or 2");
  require(detail >= 0.02 && detail <= 4, "--detail must be from 0.02 to 4");
  require(noise >= 0 && noise <= 20, "--noise must be from 0 to 20");
  return problems;
}

void ReadSize(const std::string& text, int* width, int* height) {
  const char* end = text.data() + text.size();
  const auto [cross, wrong] = std::from_chars(text.data(), end, *width);
  if (wrong == std::errc() && cross != end && *cross == 'x') {
    const auto [last, bad] = std::from_chars(cross + 1, end, *height);
    if (bad == std::errc() && last == end) return;
  }
  throw UsageError("synth: --size is '" + text + "'; it needs WIDTHxHEIGHT, such as 1200x800");
}

RoomPlan PlanRoom(const RoomOptions& options) {
  const std::vector<std::string> problems = options.Problems();
  if (!problems.empty()) throw UsageError("synth: " + problems.front());
  RoomPlan plan;
  plan.seed = options.seed;
  plan.kind = options.kind.empty() ? KindOfSeed(options.seed) : RoomKindNamed(options.kind);
  plan.photographs =
      options.photographs > 0 ? options.photographs : PhotographsOf(plan.kind, plan.seed);
  plan.width = options.width;
  plan.height = options.height;
  plan.noise = options.noise;
  plan.spacing_m = options.spacing_m;
  plan.detail = options.detail;
  plan.texture = options.texture;
  Random random(plan.seed * 77003 + 5);
  ChooseFigure(plan, random);
  plan.support = SupportOf(plan.kind, random);
  plan.light = LightOf(plan.kind, random);
  plan.second = options.second.empty() ? SecondOfSeed(plan.kind, plan.seed) : options.second;
  plan.hands =
      options.hands >= 0 ? options.hands : (plan.free_standing() && plan.seed % 5 == 2 ? 2 : 0);
  plan.exif = options.exif.empty() ? plan.seed % 6 != 3 : options.exif == "yes";
  plan.portrait_first = random.Uniform() < 0.6;
  const double wide = random.Uniform(27, 48);
  plan.focal_35mm[0] = wide;
  plan.focal_35mm[1] = wide * random.Uniform(1.5, 2.0);
  const int by_seed = random.Uniform() < 0.5 ? 2 : 1;
  plan.lenses = plan.kind == RoomKind::kBoth ? (options.lenses > 0 ? options.lenses : by_seed) : 1;
  return plan;
}

}  // namespace keypose::synth
