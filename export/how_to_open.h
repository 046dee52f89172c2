// What a person does with each file of an animation, said beside the files.
#pragma once

#include <string>
#include <vector>

namespace keypose::exporting {

/// The text of `how_to_open.txt`: a paragraph for each format, in the given order.
/// @param fps  of the animation, which some programs want to be told
std::string HowToOpen(const std::vector<std::string>& formats, double fps);

}  // namespace keypose::exporting
