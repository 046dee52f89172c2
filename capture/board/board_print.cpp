#include "capture/board/board_print.h"

#include <cairo-pdf.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

#include "capture/board/board_pattern.h"
#include "core/values/errors.h"

namespace keypose::capture {
namespace {

constexpr double kPointsPerMm = 72 / 25.4;
constexpr double kRim_mm = 6;      // white margin of printers on every side
constexpr double kRuler_mm = 100;  // printed beside the board

struct DestroyCairo {
  void operator()(cairo_t* context) const { cairo_destroy(context); }
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
};
using Pen = std::unique_ptr<cairo_t, DestroyCairo>;

std::string Text(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g", value);
  return text.data();
}

void RequireFits(const BoardLayout& board, const Page& page) {
  if (const auto problems = BoardProblems(board, {}); !problems.empty())
    throw UsageError("capture: " + problems.front());
  const double width = 1000 * board.Width(), height = 1000 * board.Height();
  // The ruler needs space beside the board.
  const double room_x = page.width_mm - 2 * (kRim_mm + 8), room_y = page.height_mm - 2 * kRim_mm;
  if (width <= room_x && height <= room_y) return;
  const double largest =
      std::floor(10 * std::min(room_x / board.columns, room_y / board.rows)) / 10;
  throw UsageError("capture: a calibration board of " + Text(width) + " x " + Text(height) +
                   " mm does not fit on " + page.name + " (" + Text(page.width_mm) + " x " +
                   Text(page.height_mm) + " mm); with " + std::to_string(board.columns) + " x " +
                   std::to_string(board.rows) + " squares --board_square_mm may be " +
                   Text(largest) + " at most, or take a larger --board_page");
}

void Fill(cairo_t* pen, double x, double y, double width, double height) {
  cairo_rectangle(pen, x, y, width, height);
  cairo_fill(pen);
}

/// Black squares and markers; the origin is the board's top left corner, y down, in millimetres.
void DrawBoard(cairo_t* pen, const BoardLayout& board) {
  const double square = 1000 * board.square_m, size = 1000 * board.marker_m,
               inset = (square - size) / 2;
  int marker = 0;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column) {
      const double x = column * square, y = row * square;
      if ((row + column) % 2 == 0) {
        Fill(pen, x, y, square, square);
        continue;
      }
      const auto ink = MarkerInk(kOwnDictionary, marker++);
      const double cell = size / static_cast<double>(ink.size());
      // One rectangle per run of ink, so that viewers draw no hairlines within it.
      for (std::size_t r = 0; r < ink.size(); ++r)
        for (std::size_t c = 0; c < ink.size();) {
          std::size_t end = c;
          while (end < ink.size() && ink[r][end]) ++end;
          if (end > c)
            Fill(pen, x + inset + static_cast<double>(c) * cell,
                 y + inset + static_cast<double>(r) * cell, static_cast<double>(end - c) * cell,
                 cell);
          c = end + 1;
        }
    }
}

/// A thin cross and a ring, in red so that they are not detected as corners.
void DrawCenter(cairo_t* pen, double x, double y) {
  cairo_set_source_rgb(pen, 0.85, 0.1, 0.1);
  cairo_set_line_width(pen, 0.25);
  for (const auto& [dx, dy] : {std::pair{4.0, 0.0}, {0.0, 4.0}}) {
    cairo_move_to(pen, x - dx, y - dy);
    cairo_line_to(pen, x + dx, y + dy);
    cairo_stroke(pen);
  }
  cairo_arc(pen, x, y, 2.5, 0, 2 * 3.14159265358979);
  cairo_stroke(pen);
  cairo_set_source_rgb(pen, 0, 0, 0);
}

void Write(cairo_t* pen, double x, double y, double size_mm, const std::string& text) {
  cairo_select_font_face(pen, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(pen, size_mm);
  cairo_move_to(pen, x, y);
  cairo_text_path(pen, text.c_str());
  cairo_fill(pen);
}

/// A ruler that runs upwards from (x, y), its numbers to its right.
void DrawRuler(cairo_t* pen, double x, double y) {
  cairo_set_line_width(pen, 0.2);
  for (int mm = 0; mm <= static_cast<int>(kRuler_mm); ++mm) {
    double tick = 1.6;
    if (mm % 5 == 0) tick = 2.8;
    if (mm % 10 == 0) tick = 4;
    cairo_move_to(pen, x, y - mm);
    cairo_line_to(pen, x + tick, y - mm);
    if (mm % 50 == 0) {
      cairo_stroke(pen);
      Write(pen, x + tick + 0.7, y - mm + 0.9, 2.6, std::to_string(mm));
    }
  }
  cairo_move_to(pen, x, y);
  cairo_line_to(pen, x, y - kRuler_mm);
  cairo_stroke(pen);
}

/// Lines of text that run upwards along the left of the board.
void WriteUpwards(cairo_t* pen, double x, double y, const std::vector<std::string>& lines) {
  cairo_save(pen);
  cairo_translate(pen, x, y);
  cairo_rotate(pen, -3.14159265358979 / 2);
  for (std::size_t i = 0; i < lines.size(); ++i)
    Write(pen, 0, 2.2 + 3.4 * static_cast<double>(i), 2.6, lines[i]);
  cairo_restore(pen);
}

cairo_status_t Append(void* text, const unsigned char* data, unsigned int length) {
  static_cast<std::string*>(text)->append(reinterpret_cast<const char*>(data), length);
  return CAIRO_STATUS_SUCCESS;
}

void Draw(cairo_t* pen, const BoardLayout& board, const Page& page) {
  const double width = 1000 * board.Width(), height = 1000 * board.Height();
  const double left = (page.width_mm - width) / 2, top = (page.height_mm - height) / 2;
  cairo_save(pen);
  cairo_translate(pen, left, top);
  DrawBoard(pen, board);
  cairo_restore(pen);
  DrawCenter(pen, page.width_mm / 2, page.height_mm / 2);
  const double ruler = std::min(left + width + std::min(4.0, (left - kRim_mm - 8) / 2 + 1),
                                page.width_mm - kRim_mm - 8);
  DrawRuler(pen, ruler, page.height_mm / 2 + kRuler_mm / 2);
  const std::string size = std::to_string(board.columns) + " x " + std::to_string(board.rows) +
                           " squares of " + Text(1000 * board.square_m) + " mm, markers " +
                           Text(1000 * board.marker_m) + " mm, DICT_5X5_100";
  std::vector<std::string> lines = {"Keypose calibration board: " + size};
  if (left - kRim_mm > 12)
    lines = {
        "Keypose calibration board: " + size,
        "Print at 100 % (no \"fit to page\"), measure the ruler, glue it flat on the turntable.",
        "It turns with the figure; leave its rim free. Ruler not 100 mm? Give the measured side of "
        "a square as --board_square_mm."};
  WriteUpwards(pen, kRim_mm, page.height_mm - top, lines);
}

}  // namespace

Page PageNamed(const std::string& name) {
  for (const Page& page :
       {Page{"A4", 297, 210}, Page{"A3", 420, 297}, Page{"letter", 279.4, 215.9}})
    if (page.name == name) return page;
  throw UsageError("capture: no page is named '" + name + "'; A4, A3 and letter are known");
}

std::string BoardPdf(const BoardLayout& board, const Page& page) {
  RequireFits(board, page);
  std::string pdf;
  const std::unique_ptr<cairo_surface_t, DestroyCairo> surface(cairo_pdf_surface_create_for_stream(
      Append, &pdf, page.width_mm * kPointsPerMm, page.height_mm * kPointsPerMm));
  cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_TITLE,
                                 "Keypose calibration board");
  cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_CREATE_DATE,
                                 "2000-01-01T00:00:00Z");  // same bytes at every call
  {
    const Pen pen(cairo_create(surface.get()));
    cairo_scale(pen.get(), kPointsPerMm, kPointsPerMm);
    Draw(pen.get(), board, page);
    cairo_show_page(pen.get());
  }
  cairo_surface_finish(surface.get());
  if (const cairo_status_t status = cairo_surface_status(surface.get());
      status != CAIRO_STATUS_SUCCESS)
    throw SolverError(std::string("capture: the board's page could not be drawn: ") +
                      cairo_status_to_string(status));
  return pdf;
}

Image8 BoardPicture(const BoardLayout& board, const Page& page, double px_per_mm) {
  RequireFits(board, page);
  Image8 picture(static_cast<int>(std::lround(page.width_mm * px_per_mm)),
                 static_cast<int>(std::lround(page.height_mm * px_per_mm)), 1);
  const std::unique_ptr<cairo_surface_t, DestroyCairo> surface(
      cairo_image_surface_create(CAIRO_FORMAT_RGB24, picture.width, picture.height));
  {
    const Pen pen(cairo_create(surface.get()));
    cairo_set_source_rgb(pen.get(), 1, 1, 1);
    cairo_paint(pen.get());
    cairo_set_source_rgb(pen.get(), 0, 0, 0);
    cairo_scale(pen.get(), px_per_mm, px_per_mm);
    Draw(pen.get(), board, page);
  }
  cairo_surface_flush(surface.get());
  const unsigned char* pixels = cairo_image_surface_get_data(surface.get());
  const int stride = cairo_image_surface_get_stride(surface.get());
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      *picture.at(x, y) = pixels[y * stride + 4 * x + 1];  // green
  return picture;
}

}  // namespace keypose::capture
