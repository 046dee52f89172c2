// Numbers and arrays as USDA writes them.
#pragma once

#include <string>
#include <vector>

#include "core/values/mesh.h"

namespace keypose::exporting {

/// The shortest text that reads back as the same number.
std::string ShortNumber(double value);

/// "[(x, y, z), ...]", numbers in single precision. Rows may have two or three columns.
std::string TupleArray(const PointsX3& rows);
std::string TupleArray(const UvsX2& rows);
/// "[a, b, ...]"
std::string NumberArray(const std::vector<int>& numbers);

}  // namespace keypose::exporting
