// The order of numbered files.
#pragma once

#include <filesystem>
#include <vector>

namespace keypose::studio {

/// In the order of the numbers in their names, of four digits or, from 10000 on, of five.
void SortByNumber(std::vector<std::filesystem::path>* files);

}  // namespace keypose::studio
