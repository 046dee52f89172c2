// Which calibration board to look for in the photographs of a pose.
#pragma once

#include <optional>
#include <vector>

#include "capture/board/board_detection.h"
#include "capture/board/board_pattern.h"
#include "capture/capture_options.h"
#include "capture/photograph_import.h"
#include "core/stage/stage_context.h"
#include "core/values/image.h"

namespace keypose::capture {

/// Corners of the board in a picture. Other boards are also looked for in pictures of webcams.
std::vector<BoardCorner> CornersOf(const Image8& image, const BoardPattern& pattern);

/// The board to look for in all photographs; none where a few of them show none that can be used.
/// Markers of another board may lie so that the wished one explains them with a shift, so that what
/// is seen is looked at without a wish too. Says what the photographs show where that is not the
/// wished board.
/// @throws InputError  they show another board than was said
std::optional<BoardPattern> BoardToFind(StageContext& stage, const PhotographImport& import,
                                        const CaptureOptions& options);

}  // namespace keypose::capture
