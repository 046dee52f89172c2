#include "export/usd/usda_text.h"

#include <charconv>

namespace keypose::exporting {
namespace {

template <class Number>
void Append(std::string& text, Number value) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  text.append(digits, end);
}

template <class Rows>
std::string Tuples(const Rows& rows) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    text += i > 0 ? ", (" : "(";
    for (Eigen::Index c = 0; c < rows.cols(); ++c) {
      if (c > 0) text += ", ";
      Append(text, static_cast<float>(rows(i, c)));
    }
    text += ')';
  }
  return text + ']';
}

}  // namespace

std::string ShortNumber(double value) {
  std::string text;
  Append(text, value);
  return text;
}

std::string TupleArray(const PointsX3& rows) { return Tuples(rows); }

std::string TupleArray(const UvsX2& rows) { return Tuples(rows); }

std::string NumberArray(const std::vector<int>& numbers) {
  std::string text = "[";
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (i > 0) text += ", ";
    Append(text, numbers[i]);
  }
  return text + ']';
}

}  // namespace keypose::exporting
