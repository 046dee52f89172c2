#include "core/values/calibration_board.h"

#include <cmath>

namespace keypose {

Eigen::Vector3d BoardLayout::Corner(int id) const {
  const int column = id % (columns - 1), row = id / (columns - 1);
  return {(column + 1) * square_m - Width() / 2, Height() / 2 - (row + 1) * square_m, 0};
}

std::vector<std::string> BoardLayout::Problems() const {
  constexpr int kMostSquares = 200;  // along a side
  std::vector<std::string> problems;
  const std::string size = std::to_string(columns) + " x " + std::to_string(rows);
  if (columns < 3 || rows < 3)
    problems.push_back("a calibration board has at least 3 x 3 squares, not " + size);
  else if (columns > kMostSquares || rows > kMostSquares)
    problems.push_back("a calibration board has at most " + std::to_string(kMostSquares) +
                       " squares along a side, not " + size + "; use fewer squares");
  if (!(std::isfinite(square_m) && square_m > 0))
    problems.push_back("the calibration board's squares must have a positive size");
  if (!(marker_m > 0 && marker_m < square_m))
    problems.push_back("the calibration board's markers must be smaller than its squares");
  return problems;
}

}  // namespace keypose
