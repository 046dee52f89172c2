// Which texel of a vertex animation texture holds which vertex of which frame.
#pragma once

namespace keypose::exporting {

constexpr int kMostVatColumns = 8192;
/// the largest texture that graphics cards since 2012 hold
constexpr int kMostVatRows = 16384;

/// Frame f fills the rows from f * rows_per_frame on. Vertex v lies in column v % columns of row
/// v / columns of its frame. The top row is 0.
struct VatLayout {
  int vertices = 0, frames = 0;
  int columns = 0, rows_per_frame = 0;
  int rows() const { return frames * rows_per_frame; }
};

/// As few rows per frame as possible, and then as few columns.
/// @throws InputError  more than kMostVatRows rows; says how many frames would fit
VatLayout MakeVatLayout(int vertices, int frames);

}  // namespace keypose::exporting
