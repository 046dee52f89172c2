// Which board to look for: what a person said, and what pictures show.
#pragma once

#include <optional>
#include <string>

#include "capture/board/board_pattern.h"
#include "core/values/board_print.h"

namespace keypose::capture {

/// Keypose's own board, as far as nothing else was said.
/// @param square_m  side of a square where it was not said
BoardPattern PatternOf(const SaidBoard& said, double square_m);

/// Whether what is seen may be Keypose's own board of this layout: its last rows may be under the
/// figure.
bool IsOwnPrint(const BoardPattern& seen, const BoardLayout& own);

/// Whether its markers may be as large as those of Keypose's own board: small ones are seen up to a
/// tenth of a square wrong.
bool HasOwnMarkers(const BoardLayout& seen);

/// The board that is seen, with what was said where pictures do not tell: the side of a square, the
/// markers' size, rows that are out of sight. Markers of Keypose's own print that are seen almost
/// as large as they are get their exact size.
/// @throws InputError  it is another board than was said; names both, and the text that says it
BoardPattern SeenAsSaid(const BoardPattern& seen, const SaidBoard& said, double square_m);

}  // namespace keypose::capture
