#include "views/shot/view_for_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/values/errors.h"

namespace keypose {
namespace {

constexpr int kBlock_px = 16;     // encoders work in blocks of this side
constexpr double kBlack = 40;     // grey levels; video's black with the noise of compression
constexpr double kLeastUp = 0.5;  // of the up vector along the picture's side, for a quarter turn

struct Size {
  int width = 0, height = 0;
};

std::string Text(const Size& size) { return fmt::format("{} x {}", size.width, size.height); }

/// A calibrated camera seen in other pixels: x' = x * scale + shift.
Camera Moved(const Camera& camera, const Eigen::Array2d& scale, const Eigen::Array2d& shift,
             const Size& size) {
  Camera moved = camera;
  moved.width = size.width;
  moved.height = size.height;
  moved.fx *= scale.x();
  moved.cx = camera.cx * scale.x() + shift.x();
  moved.fy *= scale.y();
  moved.cy = camera.cy * scale.y() + shift.y();
  return moved;
}

/// What of the film is known, and the pictures that it was calibrated with.
struct Question {
  Camera camera;
  Size film;
  const Image8& picture;
};

struct Answer {
  Camera camera;
  std::string note;  // after "the film of camera X"
};

std::optional<Answer> Scaled(const Question& q) {
  const double factor = static_cast<double>(q.film.width) / q.camera.width;
  if (std::abs(q.camera.height * factor - q.film.height) > 1) return {};
  Answer answer{q.camera.Scaled(factor), {}};
  answer.camera.width = q.film.width;
  answer.camera.height = q.film.height;
  if (factor != 1)
    answer.note = fmt::format("has {} pixels, its calibration {}: scaled by {:.4g}", Text(q.film),
                              Text({q.camera.width, q.camera.height}), factor);
  return answer;
}

bool IsBlack(const Image8& picture, bool row, int line) {
  const int length = row ? picture.width : picture.height;
  int bright = 0;
  for (int i = 0; i < length; ++i) {
    const std::uint8_t* pixel = row ? picture.at(i, line) : picture.at(line, i);
    bright += *std::max_element(pixel, pixel + picture.channels) > kBlack;
  }
  return 100 * bright <= length;
}

/// Black rows (or columns) from the picture's start or end.
int BlackLines(const Image8& picture, bool rows, bool from_end) {
  const int count = rows ? picture.height : picture.width;
  int black = 0;
  while (black < count && IsBlack(picture, rows, from_end ? count - 1 - black : black)) ++black;
  return black;
}

std::optional<Answer> Bordered(const Question& q) {
  const double across = static_cast<double>(q.film.width) / q.camera.width,
               along = static_cast<double>(q.film.height) / q.camera.height;
  const bool rows = across < along;
  const double scale = std::min(across, along);
  const int whole = rows ? q.film.height : q.film.width;
  const double border = (whole - scale * (rows ? q.camera.height : q.camera.width)) / 2;
  int first = BlackLines(q.picture, rows, false), last = BlackLines(q.picture, rows, true);
  constexpr double kLeeway_px = 2;  // sizes are rounded to even numbers
  if (first < 1 || last < 1 || std::abs(first - border) > kLeeway_px ||
      std::abs(last - border) > kLeeway_px)
    return {};
  // The scene beside a border may be black as well, or bleed into it: alike to a pixel is alike.
  if (std::abs(first - last) <= 1) first = last = static_cast<int>(std::lround(border));
  const double shown =
      static_cast<double>(whole - first - last) / (rows ? q.camera.height : q.camera.width);
  const Eigen::Array2d scales = rows ? Eigen::Array2d(across, shown) : Eigen::Array2d(shown, along);
  const Eigen::Array2d shift = rows ? Eigen::Array2d(0, first) : Eigen::Array2d(first, 0);
  return Answer{Moved(q.camera, scales, shift, q.film),
                fmt::format("has {} pixels, its calibration {}: scaled by {:.4g} between black "
                            "borders of {} and {} pixels at {}",
                            Text(q.film), Text({q.camera.width, q.camera.height}), scale, first,
                            last, rows ? "top and bottom" : "left and right")};
}

Answer CutBy(const Question& q, double scale) {
  const double right = scale * q.camera.width - q.film.width,
               bottom = scale * q.camera.height - q.film.height;
  std::string cut;
  for (const auto& [pixels, border] : {std::pair{right, "right"}, {bottom, "bottom"}})
    if (pixels > 0.5)
      cut += fmt::format("{}{:.0f} pixels at the {}", cut.empty() ? "" : " and ", pixels, border);
  return {Moved(q.camera, {scale, scale}, {0, 0}, q.film),
          fmt::format("has {} pixels, its calibration {}: {}{} taken as cut off", Text(q.film),
                      Text({q.camera.width, q.camera.height}),
                      scale == 1 ? "" : fmt::format("scaled by {:.4g}, ", scale), cut)};
}

std::optional<Answer> Cut(const Question& q) {
  const auto within = [](double cut, double most) { return cut >= 0 && cut <= most; };
  const int right = q.camera.width - q.film.width, bottom = q.camera.height - q.film.height;
  if (within(right, kBlock_px) && within(bottom, kBlock_px)) return CutBy(q, 1);
  const double scale = std::max(static_cast<double>(q.film.width) / q.camera.width,
                                static_cast<double>(q.film.height) / q.camera.height);
  const double most = kBlock_px * scale;
  if (within(scale * q.camera.width - q.film.width, most) &&
      within(scale * q.camera.height - q.film.height, most))
    return CutBy(q, scale);
  return {};
}

std::optional<Answer> AnswerFor(const Question& q) {
  for (const auto& way : {Scaled, Bordered, Cut})
    if (const std::optional<Answer> answer = way(q)) return answer;
  return {};
}

/// Quarter turns clockwise, 1 or 3, that bring the world's up to the picture's top; 0: it lies
/// along the picture already, or nobody knows.
int QuarterTurns(const View& view, const std::optional<Eigen::Vector3d>& up) {
  if (!up) return 0;
  const double right = (view.camera_from_world.rotation * up->normalized()).x();
  if (std::abs(right) < kLeastUp) return 0;
  return right < 0 ? 1 : 3;
}

View Turned(View view, int quarters) {
  for (int i = 0; i < quarters; ++i) view = TurnedClockwise(view);
  return view;
}

[[noreturn]] void Refuse(const View& view, const Size& film, const std::string& stage) {
  const Camera& camera = view.camera;
  const bool turned = (film.width > film.height) != (camera.width > camera.height);
  throw InputError(fmt::format(
      "{}: the pictures of camera {} have {} pixels, but it was calibrated with {} x {}: they are "
      "no scaled copy{}, show no black borders that would explain it, and lack more than the {} "
      "pixels that encoders cut; calibrate it with the shape of picture that it films, or, if you "
      "know how many pixels were cut at the left and at the top, take them from cx and cy of its "
      "`camera_matrix` and give the films' width and height",
      stage, view.name, Text(film), camera.width, camera.height,
      turned ? " (turned by a quarter? turn the films as they were when it was calibrated)" : "",
      kBlock_px));
}

}  // namespace

View TurnedClockwise(const View& view) {
  View turned = view;
  const Camera& c = view.camera;
  // (x, y) of the picture becomes (height - y, x); so do normalised coordinates, about 0.
  turned.camera = {c.height, c.width, c.fy, c.fx, c.height - c.cy, c.cx, c.k1, c.k2, c.p2, -c.p1};
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()));
  turned.camera_from_world = Compose({turn, Eigen::Vector3d::Zero()}, view.camera_from_world);
  return turned;
}

AdjustedView ViewForPictures(const View& calibrated, const Image8& picture,
                             const std::optional<Eigen::Vector3d>& up, const std::string& stage) {
  const Size film{picture.width, picture.height};
  AdjustedView filmed{calibrated, {}};
  if (calibrated.camera.width == 0 || calibrated.camera.height == 0) {
    filmed.view.camera.width = film.width;
    filmed.view.camera.height = film.height;
    return filmed;
  }
  std::optional<Answer> answer = AnswerFor({calibrated.camera, film, picture});
  if (!answer) {
    const int quarters = QuarterTurns(calibrated, up);
    if (quarters == 0) Refuse(calibrated, film, stage);
    filmed.view = Turned(calibrated, quarters);
    answer = AnswerFor({filmed.view.camera, film, picture});
    if (!answer) Refuse(calibrated, film, stage);
    const std::string turn = quarters == 1 ? "clockwise" : "anticlockwise";
    answer->note =
        answer->note.empty()
            ? fmt::format("has {} pixels, its calibration {} x {}: turned {}", Text(film),
                          calibrated.camera.width, calibrated.camera.height, turn)
            : answer->note + ", after a quarter turn " + turn;
  }
  filmed.view.camera = answer->camera;
  if (!answer->note.empty())
    filmed.note = fmt::format("the film of camera {} {}", calibrated.name, answer->note);
  return filmed;
}

}  // namespace keypose
