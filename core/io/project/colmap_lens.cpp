#include "core/io/project/colmap_lens.h"

#include <array>
#include <sstream>

#include "core/io/project/lens_use.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

/// `parameters`: where each number goes in a Lens, in COLMAP's order. "f" is fx and fy, k1 to k6
/// the radial factors, d1 to d3 the divisor's, s1 to s4 the prism, a and b the projection's shape.
struct Row {
  int id;
  const char* name;
  const char* parameters;
  LensProjection projection;
};

using enum LensProjection;
constexpr int kNoNumber = -1;
constexpr std::array<Row, 19> kRows{{
    {0, "SIMPLE_PINHOLE", "f cx cy", kPerspective},
    {1, "PINHOLE", "fx fy cx cy", kPerspective},
    {2, "SIMPLE_RADIAL", "f cx cy k1", kPerspective},
    {3, "RADIAL", "f cx cy k1 k2", kPerspective},
    {4, "OPENCV", "fx fy cx cy k1 k2 p1 p2", kPerspective},
    {5, "OPENCV_FISHEYE", "fx fy cx cy k1 k2 k3 k4", kEquidistant},
    {6, "FULL_OPENCV", "fx fy cx cy k1 k2 p1 p2 k3 d1 d2 d3", kPerspective},
    {7, "FOV", "fx fy cx cy a", kFieldOfView},
    {8, "SIMPLE_RADIAL_FISHEYE", "f cx cy k1", kEquidistant},
    {9, "RADIAL_FISHEYE", "f cx cy k1 k2", kEquidistant},
    {10, "THIN_PRISM_FISHEYE", "fx fy cx cy k1 k2 p1 p2 k3 k4 s1 s3", kEquidistant},
    // its tangential numbers are called the other way round
    {11, "RAD_TAN_THIN_PRISM_FISHEYE", "fx fy cx cy k1 k2 k3 k4 k5 k6 p2 p1 s1 s2 s3 s4",
     kEquidistant},
    {12, "SIMPLE_DIVISION", "f cx cy a", kDivision},
    {13, "DIVISION", "fx fy cx cy a", kDivision},
    {14, "SIMPLE_FISHEYE", "f cx cy", kEquidistant},
    {15, "FISHEYE", "fx fy cx cy", kEquidistant},
    {16, "EUCM", "fx fy cx cy a b", kEnhanced},
    {17, "EQUIRECTANGULAR", "w h", kPerspective},
    {kNoNumber, "BROWN_CONRADY", "f cx cy k1 k2 k3 p1 p2", kPerspective},
}};

std::vector<std::string> WordsOf(const char* text) {
  std::istringstream in(text);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

ColmapLensModel ModelOf(const Row& row) {
  return {row.id, row.name, static_cast<int>(WordsOf(row.parameters).size())};
}

void Put(const std::string& name, double value, Lens* lens) {
  const auto digit = static_cast<std::size_t>(name.back() - '1');
  if (name == "f") lens->fx = lens->fy = value;
  if (name == "fx") lens->fx = value;
  if (name == "fy") lens->fy = value;
  if (name == "cx") lens->cx = value;
  if (name == "cy") lens->cy = value;
  if (name == "p1") lens->p1 = value;
  if (name == "p2") lens->p2 = value;
  if (name == "a") lens->shape[0] = value;
  if (name == "b") lens->shape[1] = value;
  if (name[0] == 'k') lens->radial.at(digit) = value;
  if (name[0] == 'd') lens->divisor.at(digit) = value;
  if (name[0] == 's') lens->prism.at(digit) = value;
}

}  // namespace

std::vector<ColmapLensModel> ColmapLensModels() {
  std::vector<ColmapLensModel> models;
  for (const Row& row : kRows) models.push_back(ModelOf(row));
  return models;
}

std::optional<ColmapLensModel> FindColmapModel(const std::string& name) {
  for (const Row& row : kRows)
    if (name == row.name) return ModelOf(row);
  return std::nullopt;
}

std::optional<ColmapLensModel> FindColmapModel(int id) {
  for (const Row& row : kRows)
    if (id == row.id && id != kNoNumber) return ModelOf(row);
  return std::nullopt;
}

Lens ColmapLens(const ColmapLensModel& model, const std::vector<double>& parameters,
                const std::string& where) {
  if (model.name == "EQUIRECTANGULAR") RefuseModel(model.name + " (a panorama)", where);
  Lens lens;
  lens.model = model.name;
  for (const Row& row : kRows) {
    if (model.name != row.name) continue;
    const std::vector<std::string> names = WordsOf(row.parameters);
    if (names.size() != parameters.size())
      throw InputError(where + " has " + std::to_string(parameters.size()) + " parameters, but " +
                       model.name + " has " + std::to_string(names.size()) + ": " + row.parameters);
    for (std::size_t i = 0; i < names.size(); ++i) Put(names[i], parameters[i], &lens);
    lens.projection = row.projection;
    lens.radial_first = model.name == "RAD_TAN_THIN_PRISM_FISHEYE";
  }
  return lens;
}

}  // namespace keypose
