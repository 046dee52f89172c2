#include "synth/rooms/surfaces.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "synth/rooms/canvas.h"

namespace keypose::synth {
namespace {

using Eigen::Vector2d;

constexpr double kTurn = 6.283185307179586;

std::uint32_t SeedOf(Random& random) { return static_cast<std::uint32_t>(random.Below(1 << 24)); }

double Step(double value, double from, double to) {
  const double t = std::clamp((value - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

/// 1 inside bands of width `band`, one each `period`, with soft edges.
double Bands(double x, double period, double band) {
  const double from_middle = std::abs(x / period - std::round(x / period)) * period;
  return 1 - Step(from_middle, band / 2 - 0.0004, band / 2 + 0.0004);
}

void Checks(Canvas& cloth, Random& random, const Ink& ink, const Ink& second) {
  const double period = random.Uniform(0.028, 0.05), band = period * random.Uniform(0.35, 0.55),
               fine = period * random.Uniform(0.08, 0.14);
  cloth.Tint(ink, [=](double x, double) { return 0.55 * Bands(x, period, band); });
  cloth.Tint(ink, [=](double, double y) { return 0.55 * Bands(y, period, band); });
  cloth.Tint(second, [=](double x, double y) {
    return 0.8 * std::max(Bands(x + period / 2, period, fine), Bands(y + period / 2, period, fine));
  });
}

void Dots(Canvas& cloth, Random& random, const Ink& ink, const Ink& second) {
  const double period = random.Uniform(0.022, 0.036), radius = period * random.Uniform(0.18, 0.3);
  for (int j = 0; j * period < cloth.height_m() + period; ++j)
    for (int i = 0; i * period < cloth.width_m() + period; ++i) {
      const Vector2d at((i + 0.5 * (j % 2)) * period, j * period);
      cloth.Disc(at, radius * random.Uniform(0.92, 1.08), (i + 2 * j) % 5 == 0 ? second : ink);
    }
}

void Flowers(Canvas& cloth, Random& random, const Ink& ink, const Ink& second) {
  const int count = static_cast<int>(cloth.width_m() * cloth.height_m() / 0.0016);
  const Ink leaf = InkOf(random.Uniform(0.25, 0.4), 0.6, 0.55);
  for (int i = 0; i < count; ++i) {
    const Vector2d at(random.Uniform(0, cloth.width_m()), random.Uniform(0, cloth.height_m()));
    const double size = random.Uniform(0.006, 0.015), turn = random.Uniform(0, kTurn);
    const auto towards = [&](double angle) { return Vector2d(std::cos(angle), std::sin(angle)); };
    cloth.Line(at, at + 2.6 * size * towards(turn), 0.12 * size, leaf);
    cloth.Disc(at + 2 * size * towards(turn + 0.25), 0.4 * size, leaf);
    const int petals = 5 + random.Below(3);
    for (int p = 0; p < petals; ++p)
      cloth.Disc(at + 0.62 * size * towards(turn + kTurn * p / petals), 0.36 * size,
                 i % 3 ? ink : second);
    cloth.Disc(at, 0.3 * size, i % 3 ? second : ink);
  }
}

void Stripes(Canvas& cloth, Random& random, const Ink& ink, const Ink& second) {
  double x = 0;
  while (x < cloth.width_m()) {
    const double width = random.Uniform(0.003, 0.022);
    cloth.Bar({x + width / 2, cloth.height_m() / 2}, {width, cloth.height_m()}, 0,
              random.Uniform() < 0.6 ? ink : second);
    x += width + random.Uniform(0.004, 0.02);
  }
  // Woven figures across the stripes.
  for (double y = 0.03; y < cloth.height_m(); y += random.Uniform(0.05, 0.09))
    for (double at = random.Uniform(0, 0.02); at < cloth.width_m(); at += 0.017)
      cloth.Bar({at, y}, {0.006, 0.006}, kTurn / 8, second);
}

/// Threads, folds and stains.
void Weave(Canvas& cloth, Random& random) {
  const std::uint32_t seed = SeedOf(random);
  const double thread = 0.0011;
  cloth.Shade([=](double x, double y) {
    const double warp = std::sin(kTurn * x / thread), weft = std::sin(kTurn * y / thread);
    const double slub = PlaneFractal(x / 0.02, y / 0.0012, 2, 0.6, seed) +
                        PlaneFractal(x / 0.0012, y / 0.02, 2, 0.6, seed + 7);
    return 1 + 0.05 * warp * weft + 0.16 * slub;
  });
  const double direction = random.Uniform(0, kTurn);
  cloth.Shade([=](double x, double y) {
    const double along = x * std::cos(direction) + y * std::sin(direction);
    const double folds = PlaneNoise(along / 0.09, (x + y) / 0.6, seed + 13),
                 stains = PlaneFractal(x / 0.12, y / 0.12, 3, 0.5, seed + 17);
    return 1 + 0.22 * folds + 0.10 * stains;
  });
}

void Motifs(Canvas& wall, Random& random, const Ink& ink) {
  const double period = random.Uniform(0.09, 0.16);
  const int petals = 3 + random.Below(4);
  for (int j = 0; j * period < wall.height_m() + period; ++j)
    for (int i = 0; i * period < wall.width_m() + period; ++i) {
      const Vector2d at((i + 0.5 * (j % 2)) * period, j * period);
      for (int p = 0; p < petals; ++p) {
        const double angle = kTurn * p / petals + 0.4;
        const Vector2d out(std::cos(angle), std::sin(angle));
        wall.Line(at, at + 0.36 * period * out, 0.05 * period, ink);
        wall.Disc(at + 0.36 * period * out, 0.09 * period, ink);
      }
      wall.Ring(at, 0.16 * period, 0.03 * period, ink);
    }
}

}  // namespace

Print ClothPrint(double width_m, double height_m, PrintRandom random) {
  const double hue = random.Uniform();
  const bool pale = random.Uniform() < 0.6;
  const Ink ground = pale ? InkOf(hue, random.Uniform(0.02, 0.14), 0.9)
                          : InkOf(hue, random.Uniform(0.35, 0.7), random.Uniform(0.35, 0.6));
  const Ink ink = InkOf(hue + random.Uniform(0.3, 0.7), random.Uniform(0.5, 0.85),
                        pale ? random.Uniform(0.4, 0.7) : 0.9),
            second = InkOf(hue + random.Uniform(0.1, 0.9), random.Uniform(0.5, 0.8),
                           random.Uniform(0.3, 0.8));
  Canvas cloth(width_m, height_m, random.Fine(2200), ground);
  const int kind = random.Below(4);
  if (kind == 0) Checks(cloth, random, ink, second);
  if (kind == 1) Dots(cloth, random, ink, second);
  if (kind == 2) Flowers(cloth, random, ink, second);
  if (kind == 3) Stripes(cloth, random, ink, second);
  Weave(cloth, random);
  return std::move(cloth).Done();
}

Print BoardsPrint(double width_m, double height_m, double board_m, PrintRandom random) {
  const std::uint32_t seed = SeedOf(random);
  const Ink wood =
      InkOf(random.Uniform(0.06, 0.11), random.Uniform(0.35, 0.65), random.Uniform(0.4, 0.75));
  Canvas boards(width_m, height_m,
                random.Fine(std::min(1600.0, 2400 / std::max(width_m, height_m))), wood);
  boards.Shade([=](double x, double y) {
    const double board = std::floor(y / board_m), shift = 17.3 * board,
                 in_board = y / board_m - board;
    const double rings = PlaneFractal(6 * x + shift, 110 * y, 4, 0.6, seed),
                 knots = PlaneNoise(14 * x + shift, 40 * y, seed + 1),
                 pores = PlaneNoise(120 * x, 900 * y, seed + 2);
    const double gap = 1 - Step(std::min(in_board, 1 - in_board) * board_m, 0.0004, 0.0014);
    const double tone = PlaneNoise(3.7 * board + 0.5, 0.5, seed + 3);
    return (1 + 0.30 * rings + 0.18 * knots + 0.10 * pores + 0.25 * tone) * (1 - 0.6 * gap);
  });
  return std::move(boards).Done();
}

Print WallPrint(double width_m, double height_m, PrintRandom random) {
  const double hue = random.Uniform();
  const Ink ground = InkOf(hue, random.Uniform(0.04, 0.3), random.Uniform(0.6, 0.9));
  Canvas wall(width_m, height_m, random.Fine(2000 / std::max(width_m, height_m)), ground);
  if (random.Uniform() < 0.6)
    Motifs(wall, random, Mixed(ground, InkOf(hue + 0.1, 0.5, 0.5), random.Uniform(0.2, 0.6)));
  const std::uint32_t seed = SeedOf(random);
  wall.Shade([=](double x, double y) {
    return 1 + 0.07 * PlaneFractal(x / 0.35, y / 0.35, 4, 0.6, seed) +
           0.06 * PlaneFractal(x / 0.006, y / 0.006, 2, 0.6, seed + 5);
  });
  return std::move(wall).Done();
}

Print CarpetPrint(double width_m, double height_m, PrintRandom random) {
  const double hue = random.Uniform();
  Canvas carpet(width_m, height_m, random.Fine(2000 / std::max(width_m, height_m)),
                InkOf(hue, 0.45, random.Uniform(0.35, 0.6)));
  const Ink light = InkOf(hue + 0.4, 0.3, 0.75), dark = InkOf(hue + 0.6, 0.5, 0.3);
  const double w = carpet.width_m(), h = carpet.height_m();
  for (int i = 0; i < 6; ++i) {
    const double in = 0.05 + 0.07 * i;
    const Ink& ink = i % 2 ? dark : light;
    for (const double y : {in, h - in}) carpet.Bar({w / 2, y}, {w - 2 * in, 0.025}, 0, ink);
    for (const double x : {in, w - in}) carpet.Bar({x, h / 2}, {0.025, h - 2 * in}, 0, ink);
  }
  for (int i = 0; i < 160; ++i) {
    const Vector2d at(random.Uniform(0.5, w - 0.5), random.Uniform(0.5, h - 0.5));
    const double size = random.Uniform(0.04, 0.12), turn = random.Uniform(0, kTurn);
    carpet.Bar(at, {size, size}, turn, i % 3 ? light : dark);
    carpet.Bar(at, {0.5 * size, 0.5 * size}, turn, i % 2 ? dark : light);
  }
  carpet.Grain(0.006, 0.45, 2, SeedOf(random));
  return std::move(carpet).Done();
}

Print MasonryPrint(double width_m, double height_m, PrintRandom random) {
  const bool bricks = random.Uniform() < 0.5;
  const Ink stone = bricks ? InkOf(random.Uniform(0.01, 0.05), 0.6, 0.6)
                           : InkOf(random.Uniform(0.08, 0.14), 0.2, 0.7),
            mortar = InkOf(0.1, 0.1, random.Uniform(0.5, 0.75));
  Canvas wall(width_m, height_m, random.Fine(2600 / std::max(width_m, height_m)), mortar);
  const double high = bricks ? 0.065 : random.Uniform(0.12, 0.2), gap = bricks ? 0.010 : 0.007;
  for (double y = 0; y < height_m; y += high + gap)
    for (double x = -random.Uniform(0, 0.3); x < width_m;) {
      const double wide = bricks ? 0.21 : random.Uniform(0.18, 0.42);
      wall.Bar({x + wide / 2, y + high / 2}, {wide, high}, random.Uniform(-0.008, 0.008),
               Mixed(stone, InkOf(random.Uniform(0, 0.12), 0.4, random.Uniform(0.3, 0.8)), 0.3));
      x += wide + gap;
    }
  const std::uint32_t seed = SeedOf(random);
  wall.Shade([=](double x, double y) {
    const double pits = PlaneNoise(x / 0.004, y / 0.004, seed + 3);
    return (1 + 0.28 * PlaneFractal(x / 0.03, y / 0.03, 4, 0.65, seed)) *
           (1 - 0.4 * Step(pits, 0.35, 0.6));
  });
  return std::move(wall).Done();
}

Print BarkPrint(double width_m, double height_m, double pixels_per_m, PrintRandom random) {
  const Ink bark = InkOf(random.Uniform(0.05, 0.1), random.Uniform(0.25, 0.45), 0.5);
  Canvas canvas(width_m, height_m, random.Fine(pixels_per_m), bark);
  const std::uint32_t seed = SeedOf(random);
  // Towards its right border a picture of noise turns into that of its left one.
  const auto closed = [=](auto noise) {
    return [=](double x, double y) {
      const double share = (x / width_m - 0.85) / 0.15;
      if (share <= 0) return noise(x, y);
      return (1 - share) * noise(x, y) + share * noise(x - width_m, y);
    };
  };
  const auto ridges = closed([=](double x, double y) {
    return PlaneFractal(x / 0.018 + 0.8 * std::sin(y / 0.11), y / 0.09, 3, 0.55, seed);
  });
  const auto flakes = closed(
      [=](double x, double y) { return PlaneFractal(x / 0.006, y / 0.012, 3, 0.65, seed + 9); });
  const auto moss = closed(
      [=](double x, double y) { return PlaneFractal(x / 0.12, y / 0.2, 4, 0.6, seed + 21); });
  canvas.Shade([=](double x, double y) {
    return (0.45 + 1.1 * Step(std::abs(ridges(x, y)), 0.02, 0.35)) * (1 + 0.45 * flakes(x, y));
  });
  canvas.Tint(InkOf(random.Uniform(0.22, 0.3), 0.5, 0.5),
              [=](double x, double y) { return 0.7 * Step(moss(x, y), 0.15, 0.4); });
  return std::move(canvas).Done(true);
}

Print LeavesPrint(double width_m, double height_m, PrintRandom random) {
  Canvas floor(width_m, height_m, random.Fine(2200 / std::max(width_m, height_m)),
               InkOf(0.08, 0.45, 0.28));
  const int count = static_cast<int>(width_m * height_m * 420);
  for (int i = 0; i < count; ++i) {
    const Vector2d at(random.Uniform(0, width_m), random.Uniform(0, height_m));
    const double turn = random.Uniform(0, kTurn), size = random.Uniform(0.02, 0.06);
    const Ink leaf =
        InkOf(random.Uniform(0.04, 0.2), random.Uniform(0.3, 0.75), random.Uniform(0.25, 0.75));
    const Vector2d along(std::cos(turn), std::sin(turn)), across(-along.y(), along.x());
    floor.Polygon({at - size * along, at - 0.3 * size * along + 0.35 * size * across,
                   at + 0.4 * size * along + 0.3 * size * across, at + size * along,
                   at + 0.4 * size * along - 0.3 * size * across,
                   at - 0.3 * size * along - 0.35 * size * across},
                  leaf);
    floor.Line(at - size * along, at + size * along, 0.0012, Mixed(leaf, {30, 20, 10}, 0.5));
  }
  floor.Grain(0.01, 0.35, 3, SeedOf(random));
  return std::move(floor).Done();
}

Print FoliagePrint(double width_m, double height_m, PrintRandom random) {
  Canvas canvas(width_m, height_m, random.Fine(2000 / std::max(width_m, height_m)),
                InkOf(0.28, 0.5, 0.3));
  const std::uint32_t seed = SeedOf(random);
  canvas.Tint(InkOf(0.55, 0.12, 0.97), [=](double x, double y) {
    const double high = 0.5 * (0.55 * height_m - y) / height_m;
    return Step(PlaneFractal(x / 0.4, y / 0.4, 6, 0.62, seed) + high, 0.1, 0.22);
  });
  canvas.Shade([=](double x, double y) {
    return 1 + 0.7 * PlaneFractal(x / 0.1, y / 0.1, 4, 0.65, seed + 4);
  });
  return std::move(canvas).Done();
}

}  // namespace keypose::synth
