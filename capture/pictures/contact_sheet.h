// One picture that shows every mask over its photograph.
#pragma once

#include <string>
#include <vector>

#include "core/values/image.h"

namespace keypose::capture {

/// A cell of the sheet: the photograph reduced to `width`, tinted outside of its mask, with the
/// mask's outline, and its name below.
/// @param image  RGB
/// @param mask   same size, one channel
Image8 ContactCell(const Image8& image, const Image8& mask, const std::string& name, int width);

/// A cell of a photograph that is not used: grey, crossed out in red, with `caption` below.
/// @param image  RGB
Image8 LeftOutCell(const Image8& image, const std::string& caption, int width);

/// Arranges cells in rows of about equal width and height.
/// @throws InputError  no cells
Image8 ContactSheet(const std::vector<Image8>& cells);

}  // namespace keypose::capture
