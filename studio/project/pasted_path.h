// A folder's path as people paste it into a page.
#pragma once

#include <string>

namespace keypose::studio {

/// Without spaces round it and the quotes of a terminal or of "Copy as path"; of a file:// address
/// the path that it stands for.
std::string PastedPath(std::string text);

}  // namespace keypose::studio
