#include "export/vat/vat_layout.h"

#include <cstdint>
#include <string>

#include "core/values/errors.h"

namespace keypose::exporting {

VatLayout MakeVatLayout(int vertices, int frames) {
  VatLayout layout;
  layout.vertices = vertices;
  layout.frames = frames;
  layout.rows_per_frame = (vertices + kMostVatColumns - 1) / kMostVatColumns;
  layout.columns = (vertices + layout.rows_per_frame - 1) / layout.rows_per_frame;
  if (std::int64_t{frames} * layout.rows_per_frame <= kMostVatRows) return layout;
  throw InputError("export: a vertex animation texture of " + std::to_string(frames) +
                   " frames with " + std::to_string(vertices) + " vertices has more than " +
                   std::to_string(kMostVatRows) + " rows; at most " +
                   std::to_string(kMostVatRows / layout.rows_per_frame) +
                   " frames fit: lower fps, shorten the timeline, or give cleanup fewer faces");
}

}  // namespace keypose::exporting
