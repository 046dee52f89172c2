#include "synth/rooms/printed.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "synth/rooms/canvas.h"

namespace keypose::synth {
namespace {

using Eigen::Vector2d;

constexpr double kRound = 6.283185307179586;
constexpr Ink kBlack = {24, 24, 28}, kPaper = {238, 236, 230};

Vector2d Out(double angle) { return {std::cos(angle), std::sin(angle)}; }

std::uint32_t GrainSeed(Random& random) {
  return static_cast<std::uint32_t>(random.Below(1 << 24));
}

Ink AnyInk(Random& random, double least = 0.2, double most = 0.95) {
  const double hue = random.Uniform(), saturation = random.Uniform(0.2, 0.9);
  return InkOf(hue, saturation, random.Uniform(least, most));
}

/// Rows of small bars: text that is too small to read.
void Lines(Canvas& sheet, const Vector2d& from, const Vector2d& size, double pitch, const Ink& ink,
           Random& random) {
  for (double y = from.y() + pitch / 2; y < from.y() + size.y(); y += pitch)
    for (double x = from.x(); x < from.x() + size.x();) {
      const double word = pitch * random.Uniform(0.8, 3.5);
      const double end = std::min(x + word, from.x() + size.x());
      sheet.Bar({(x + end) / 2, y}, {end - x, 0.42 * pitch}, 0, ink);
      x = end + 0.5 * pitch;
    }
}

/// Disc, bars, triangles and rings at random.
void Shapes(Canvas& sheet, const Vector2d& from, const Vector2d& size, int count, Random& random) {
  const double unit = std::min(size.x(), size.y());
  for (int i = 0; i < count; ++i) {
    const Vector2d at = from + Vector2d(random.Uniform() * size.x(), random.Uniform() * size.y());
    const double r = unit * random.Uniform(0.03, 0.16), turn = random.Uniform(0, kRound);
    const Ink ink = AnyInk(random);
    switch (random.Below(4)) {
      case 0:
        sheet.Disc(at, r, ink);
        break;
      case 1:
        sheet.Bar(at, {2.4 * r, 0.6 * r}, turn, ink);
        break;
      case 2:
        sheet.Ring(at, r, 0.3 * r, ink);
        break;
      default:
        sheet.Polygon({at + r * Out(turn), at + r * Out(turn + 2.2), at + r * Out(turn + 4)}, ink);
    }
  }
}

/// A turned disc in four quarters, two of them black.
void Quarters(Canvas& mat, const Vector2d& at, double radius, double turn) {
  mat.Disc(at, radius, kBlack);
  mat.Disc(at, 0.92 * radius, kPaper);
  for (const double first : {0.0, kRound / 2}) {
    std::vector<Vector2d> fan{at};
    for (int i = 0; i <= 12; ++i)
      fan.push_back(at + 0.92 * radius * Out(turn + first + kRound / 4 * i / 12));
    mat.Polygon(fan, kBlack);
  }
}

void Ticks(Canvas& mat, const Vector2d& middle, double radius, Random& random) {
  const Ink colors[3] = {kBlack, AnyInk(random, 0.3, 0.7), AnyInk(random, 0.3, 0.7)};
  mat.Ring(middle, radius, 0.0016, kBlack);
  for (int degree = 0; degree < 360; degree += 2) {
    const bool tenth = degree % 10 == 0;
    const double angle = kRound * degree / 360, length = tenth ? 0.008 : 0.003;
    mat.Line(middle + radius * Out(angle), middle + (radius - length) * Out(angle),
             tenth ? 0.0016 : 0.0007, colors[degree / 10 % 3]);
    if (!tenth) continue;
    const Vector2d end = middle + (radius - length) * Out(angle);
    if (degree % 30 == 10)
      mat.Bar(end, {0.005, 0.005}, angle + kRound / 8, colors[degree / 10 % 3]);
    if (degree % 30 == 20) mat.Disc(end, 0.0028, colors[degree / 10 % 3]);
    mat.Text(std::to_string(degree), middle + (radius - 0.0145) * Out(angle), 0.0045,
             angle + kRound / 4, kBlack);
  }
}

/// Squared paper over a pale map, with coloured corners.
void Square(Canvas& mat, const Vector2d& middle, double side, Random& random) {
  mat.Bar(middle, {side, side}, 0, InkOf(random.Uniform(), 0.1, 0.86));
  const std::uint32_t seed = GrainSeed(random);
  for (int layer = 0; layer < 3; ++layer) {
    const double level = 0.1 * layer;
    mat.Tint(AnyInk(random, 0.45, 0.8), [=](double x, double y) {
      if (std::abs(x - middle.x()) > side / 2 || std::abs(y - middle.y()) > side / 2) return 0.0;
      const double height = PlaneFractal(x / 0.025, y / 0.025, 3, 0.5, seed + 50u * layer);
      return height > level ? 0.45 : 0.0;
    });
  }
  constexpr double kPitch = 0.002;
  const int lines = static_cast<int>(std::lround(side / kPitch));
  for (int i = 0; i <= lines; ++i) {
    const double at = -side / 2 + kPitch * i, width = i % 10 == 0 ? 0.0006 : 0.00022;
    const Ink ink = i % 10 == 0 ? (i % 20 ? InkOf(0.62, 0.6, 0.5) : InkOf(0, 0.6, 0.5)) : kBlack;
    mat.Bar(middle + Vector2d(at, 0), {width, side}, 0, ink);
    mat.Bar(middle + Vector2d(0, at), {side, width}, 0, ink);
  }
  for (int corner = 0; corner < 4; ++corner) {
    const Vector2d out = Out(kRound * (corner + 0.5) / 4);
    const Ink ink = AnyInk(random, 0.5, 0.9);
    mat.Bar(middle + 0.42 * side * out * std::sqrt(2), {0.011, 0.011}, 0, ink);
    mat.Bar(middle + 0.34 * side * out * std::sqrt(2), {0.013, 0.013}, 0, ink);
    mat.Bar(middle + 0.34 * side * out * std::sqrt(2), {0.007, 0.007}, 0, kPaper);
  }
}

void Barcode(Canvas& sheet, const Vector2d& at, const Vector2d& size, Random& random) {
  sheet.Bar(at + size / 2, 1.1 * size, 0, kPaper);
  for (double x = 0; x < size.x();) {
    const double width = size.x() * random.Uniform(0.01, 0.04);
    sheet.Bar({at.x() + x + width / 2, at.y() + size.y() / 2}, {width, size.y()}, 0, kBlack);
    x += width + size.x() * random.Uniform(0.01, 0.04);
  }
}

}  // namespace

Print MatPrint(double side_m, PrintRandom random) {
  Canvas mat(side_m, side_m, random.Fine(7000), kPaper);
  const Vector2d middle(side_m / 2, side_m / 2);
  const double radius = 0.455 * side_m;
  Square(mat, middle, 0.9 * radius, random);
  Ticks(mat, middle, radius, random);
  for (int i = 0; i < 4; ++i) {
    const double angle = kRound * i / 4;
    const Vector2d at = middle + 0.74 * radius * Out(angle);
    Quarters(mat, at, 0.0095, angle);
    mat.Text(std::string(1, static_cast<char>('A' + i)), at + 0.016 * Out(angle + kRound / 4),
             0.006, angle + kRound / 4, kBlack);
    mat.Bar(middle + 0.62 * radius * Out(angle + 0.22), {0.01, 0.0022}, angle + 0.22 + kRound / 4,
            kBlack);
    mat.Text("1 cm", middle + 0.585 * radius * Out(angle + 0.22), 0.0035, angle + 0.22 + kRound / 4,
             kBlack);
    mat.Text(Word(random) + " " + std::to_string(10 + random.Below(90)),
             middle + 0.66 * radius * Out(angle + kRound / 8), 0.0045, angle + 3 * kRound / 8,
             kBlack);
  }
  for (const double y : {0.03, 0.97})
    mat.Text(Word(random) + " " + Word(random) + "  " + std::to_string(random.Below(9999)),
             {0.5 * side_m, y * side_m}, 0.0045, 0, kBlack);
  for (int corner = 0; corner < 4; ++corner)
    Barcode(mat, {(corner % 2 ? 0.86 : 0.04) * side_m, (corner / 2 ? 0.91 : 0.05) * side_m},
            {0.1 * side_m, 0.035 * side_m}, random);
  mat.Grain(0.0012, 0.04, 2, GrainSeed(random));
  mat.Grain(0.06, 0.04, 2, GrainSeed(random));
  return std::move(mat).Done();
}

Print CoverPrint(double width_m, double height_m, PrintRandom random) {
  const Ink ground = AnyInk(random), ink = AnyInk(random);
  Canvas cover(width_m, height_m, random.Fine(3500), ground);
  const double w = width_m, h = height_m;
  const std::uint32_t seed = GrainSeed(random);
  cover.Tint(ink, [=](double x, double y) {
    return 0.6 * (0.5 + PlaneFractal(x / (0.3 * w), y / (0.3 * w), 4, 0.5, seed));
  });
  Shapes(cover, {0.08 * w, 0.3 * h}, {0.84 * w, 0.42 * h}, 10 + random.Below(14), random);
  const Ink letters = random.Uniform() < 0.5 ? kPaper : kBlack;
  cover.Text(Word(random), {0.5 * w, 0.11 * h}, 0.075 * h, 0, letters);
  cover.Text(Word(random) + " " + Word(random), {0.5 * w, 0.21 * h}, 0.032 * h, 0, letters);
  Lines(cover, {0.1 * w, 0.78 * h}, {0.5 * w, 0.15 * h}, 0.02 * h, letters, random);
  Barcode(cover, {0.7 * w, 0.84 * h}, {0.2 * w, 0.08 * h}, random);
  cover.Grain(0.003, 0.06, 2, seed + 3);
  return std::move(cover).Done();
}

Print SpinePrint(double width_m, double height_m, PrintRandom random) {
  const double w = width_m, h = height_m;
  const Ink ground = random.Uniform() < 0.25 ? InkOf(0.1, 0.1, random.Uniform(0.7, 0.9))
                                             : AnyInk(random, 0.12, 0.75);
  const bool dark = ground[0] + ground[1] + ground[2] < 380;
  const Ink letters = dark ? (random.Uniform() < 0.6 ? kPaper : InkOf(0.13, 0.6, 0.8)) : kBlack;
  Canvas spine(w, h, random.Fine(2600), ground);
  for (int i = random.Below(4); i > 0; --i)
    spine.Bar({w / 2, h * random.Uniform(0.02, 0.98)}, {w, h * random.Uniform(0.006, 0.07)}, 0,
              AnyInk(random));
  const double cap = std::min(0.42 * w, 0.011);
  spine.Text(Word(random) + " " + Word(random), {w / 2, 0.42 * h}, cap, kRound / 4, letters);
  spine.Text(Word(random), {w / 2, 0.8 * h}, 0.7 * cap, kRound / 4, letters);
  if (random.Uniform() < 0.7) spine.Disc({w / 2, 0.93 * h}, 0.28 * w, AnyInk(random));
  spine.Shade([=](double x, double) {  // rounded
    const double t = 2 * x / w - 1;
    return 1 - 0.35 * t * t;
  });
  spine.Grain(0.004, 0.10, 3, GrainSeed(random));
  return std::move(spine).Done();
}

Print PagesPrint(double width_m, double height_m, PrintRandom random) {
  Canvas pages(width_m, height_m, random.Fine(2000), InkOf(0.12, random.Uniform(0.06, 0.2), 0.86));
  const std::uint32_t seed = GrainSeed(random);
  const bool flat = width_m > height_m;
  pages.Shade([=](double x, double y) {
    const double across = flat ? y : x, along = flat ? x : y;
    return 1 + 0.20 * PlaneFractal(across / 0.0011, along / 0.05, 2, 0.6, seed);
  });
  return std::move(pages).Done();
}

Print PaintingPrint(double width_m, double height_m, PrintRandom random) {
  const double w = width_m, h = height_m, frame = 0.06 * std::min(w, h);
  Canvas painting(w, h, random.Fine(1100), AnyInk(random, 0.4, 0.8));
  const std::uint32_t seed = GrainSeed(random);
  for (int i = 0; i < 4; ++i) {
    const double horizon = h * (0.35 + 0.14 * i);
    painting.Tint(AnyInk(random), [=](double x, double y) {
      const double hill = horizon + 0.12 * h * PlaneFractal(x / (0.3 * w), 0.5 + i, 4, 0.5, seed);
      return y > hill ? 0.75 : 0.15 * (0.5 + PlaneNoise(x / (0.1 * w), y / 0.05, seed));
    });
  }
  Shapes(painting, {0.15 * w, 0.3 * h}, {0.7 * w, 0.5 * h}, 4 + random.Below(14), random);
  painting.Grain(0.012, 0.25, 3, seed + 1);
  const Ink wood =
      InkOf(random.Uniform(0.06, 0.13), random.Uniform(0.2, 0.7), random.Uniform(0.15, 0.7));
  for (const double x : {frame / 2, w - frame / 2}) painting.Bar({x, h / 2}, {frame, h}, 0, wood);
  for (const double y : {frame / 2, h - frame / 2}) painting.Bar({w / 2, y}, {w, frame}, 0, wood);
  return std::move(painting).Done();
}

Print PosterPrint(double width_m, double height_m, PrintRandom random) {
  const double w = width_m, h = height_m;
  Canvas poster(w, h, random.Fine(1300), InkOf(random.Uniform(), random.Uniform(0, 0.15), 0.92));
  Shapes(poster, {0.05 * w, 0.14 * h}, {0.9 * w, 0.3 * h}, 14, random);
  poster.Text(Word(random) + " " + Word(random), {w / 2, 0.08 * h}, 0.055 * h, 0,
              AnyInk(random, 0.2, 0.6));
  const Ink ink = AnyInk(random, 0.1, 0.5);
  for (int day = 0; day < 31; ++day) {
    const Vector2d at((0.1 + 0.133 * (day % 7)) * w, (0.52 + 0.09 * (day / 7)) * h);
    poster.Text(std::to_string(day + 1), at, 0.028 * h, 0, ink);
    if (random.Uniform() < 0.2) poster.Ring(at, 0.035 * h, 0.004 * h, AnyInk(random));
    poster.Line(at + Vector2d(-0.05 * w, 0.04 * h), at + Vector2d(0.05 * w, 0.04 * h), 0.002, ink);
  }
  return std::move(poster).Done();
}

Print LabelPrint(double width_m, double height_m, PrintRandom random) {
  const double w = width_m, h = height_m;
  Canvas label(w, h, random.Fine(4000), AnyInk(random));
  for (int i = 2 + random.Below(3); i > 0; --i)
    label.Bar({w / 2, h * random.Uniform(0.05, 0.95)}, {w, h * random.Uniform(0.03, 0.14)}, 0,
              AnyInk(random));
  Shapes(label, {0, 0.1 * h}, {w, 0.8 * h}, 8 + random.Below(10), random);
  const Ink letters = random.Uniform() < 0.5 ? kPaper : kBlack;
  for (double x = 0.2 * w; x < w; x += std::max(0.3 * w, 0.09)) {
    label.Text(Word(random), {x, 0.35 * h}, 0.10 * h, 0, letters);
    Lines(label, {x - 0.1 * w, 0.6 * h}, {0.2 * w, 0.25 * h}, 0.03 * h, letters, random);
  }
  label.Grain(0.003, 0.08, 2, GrainSeed(random));
  return std::move(label).Done();
}

Print BlockPrint(double side_m, PrintRandom random) {
  const double s = side_m;
  Canvas side(s, s, random.Fine(7000),
              InkOf(random.Uniform(0.07, 0.1), random.Uniform(0.3, 0.5), 0.78));
  const std::uint32_t seed = GrainSeed(random);
  side.Shade([=](double x, double y) {
    return 1 + 0.25 * PlaneFractal(x / 0.02, y / 0.0022, 3, 0.6, seed);
  });
  const Ink ink = AnyInk(random, 0.35, 0.8);
  for (const double at : {0.06 * s, 0.94 * s}) {
    side.Bar({at, s / 2}, {0.07 * s, s}, 0, ink);
    side.Bar({s / 2, at}, {s, 0.07 * s}, 0, ink);
  }
  const char letter = static_cast<char>('A' + random.Below(26));
  side.Text(std::string(1, letter), {s / 2, s / 2}, 0.5 * s, 0, AnyInk(random, 0.2, 0.7));
  side.Grain(0.0015, 0.14, 2, seed + 1);
  return std::move(side).Done();
}

Print PaintPrint(double width_m, double height_m, PrintRandom random) {
  Canvas paint(width_m, height_m, random.Fine(900), AnyInk(random, 0.25, 0.9));
  paint.Grain(0.05, 0.12, 3, GrainSeed(random));
  paint.Grain(0.004, 0.10, 2, GrainSeed(random));
  return std::move(paint).Done();
}

}  // namespace keypose::synth
