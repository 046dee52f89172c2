#include "core/io/project/opencv_lens.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "core/io/project/lens_use.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

const std::vector<const char*> kBrownNames{
    "",       "plumbbob", "radtan",      "radialtangential", "brown",        "brownconrady",
    "opencv", "pinhole",  "perspective", "standard",         "pinholeradtan"};
const std::vector<const char*> kRationalNames{"rationalpolynomial", "rational", "rational8",
                                              "opencvrational"};
const std::vector<const char*> kPrismNames{"thinprism", "thinprismmodel", "tilted", "tiltedmodel",
                                           "fullopencv"};
const std::vector<const char*> kFisheyeNames{
    "equidistant",    "equi",    "fisheye", "opencvfisheye", "kannalabrandt",
    "kannalabrandt4", "kannala", "kb4",     "pinholeequi",   "pinholeequidistant"};
const std::vector<const char*> kFovNames{"fov", "pinholefov"};

/// Lower case, and only letters and digits: "Plumb Bob", "plumb-bob" and "plumb_bob" are one.
std::string Plain(const std::string& text) {
  std::string plain;
  for (const char c : text)
    if (std::isalnum(static_cast<unsigned char>(c)))
      plain += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return plain;
}

bool IsAny(const std::string& word, const std::vector<const char*>& words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

[[noreturn]] void ThrowCount(const std::string& model, std::size_t count, const char* wanted,
                             const std::string& where) {
  throw InputError(fmt::format("{}: its distortion has {} coefficients, but {} has {}", where,
                               count, model.empty() ? "OpenCV's" : "the model " + model, wanted));
}

/// OpenCV's order: k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 tau_x tau_y.
void PutBrown(const std::vector<double>& d, const std::string& where, Lens* lens) {
  constexpr std::array<std::size_t, 7> kCounts{0, 2, 4, 5, 8, 12, 14};
  if (std::find(kCounts.begin(), kCounts.end(), d.size()) == kCounts.end())
    ThrowCount(IsAny(Plain(lens->model), kBrownNames) ? lens->model : "", d.size(),
               "4, 5, 8, 12 or 14, in the order k1 k2 p1 p2 k3 and on; put 0 for those that it "
               "lacks",
               where);
  std::array<double, 14> all{};
  std::copy(d.begin(), d.end(), all.begin());
  lens->radial = {all[0], all[1], all[4], 0, 0, 0};
  lens->p1 = all[2];
  lens->p2 = all[3];
  lens->divisor = {all[5], all[6], all[7]};
  lens->prism = {all[8], all[9], all[10], all[11]};
  lens->tilt = {all[12], all[13]};
}

void PutFisheye(const std::vector<double>& d, const std::string& where, Lens* lens) {
  // writers fill up with zeros
  const bool more =
      std::any_of(d.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(4, d.size())),
                  d.end(), [](double number) { return number != 0; });
  if (more) ThrowCount(lens->model, d.size(), "k1 to k4", where);
  lens->projection = LensProjection::kEquidistant;
  std::copy_n(d.begin(), std::min<std::size_t>(4, d.size()), lens->radial.begin());
}

}  // namespace

bool IsLensModelName(const std::string& name) {
  const std::string plain = Plain(name);
  return IsAny(plain, kBrownNames) || IsAny(plain, kRationalNames) || IsAny(plain, kPrismNames) ||
         IsAny(plain, kFisheyeNames) || IsAny(plain, kFovNames) ||
         IsAny(plain, {"omni",
                       "omnidir",
                       "omnidirectional",
                       "mei",
                       "unified",
                       "ucm",
                       "ds",
                       "doublesphere",
                       "eucm",
                       "scaramuzza",
                       "ocam",
                       "ocamcalib",
                       "division",
                       "cylindrical",
                       "spherical",
                       "equirectangular",
                       "panorama",
                       "fisheye624",
                       "ftheta",
                       "thinprismfisheye",
                       "radtanthinprismfisheye"});
}

Lens OpenCvLens(const std::string& model, const std::vector<double>& k,
                const std::vector<double>& coefficients, const std::string& where) {
  Lens lens;
  lens.model = model;
  lens.fx = k.at(0);
  lens.fy = k.at(1);
  lens.cx = k.at(2) + 0.5;
  lens.cy = k.at(3) + 0.5;
  lens.skew = k.size() > 4 ? k[4] : 0;
  const std::string name = Plain(model);
  const std::size_t count = coefficients.size();
  if (IsAny(name, kBrownNames)) {
    if (name.empty()) lens.model = fmt::format("OpenCV's with {} coefficients", count);
    PutBrown(coefficients, where, &lens);
  } else if (IsAny(name, kRationalNames)) {
    if (count != 8 && count != 5) ThrowCount(model, count, "8", where);
    PutBrown(coefficients, where, &lens);
  } else if (IsAny(name, kPrismNames)) {
    if (count != 8 && count != 12 && count != 14)
      ThrowCount(model, count, "12, or 14 with tilt", where);
    PutBrown(coefficients, where, &lens);
  } else if (IsAny(name, kFisheyeNames)) {
    PutFisheye(coefficients, where, &lens);
  } else if (IsAny(name, kFovNames)) {
    if (count != 1) ThrowCount(model, count, "w alone", where);
    lens.projection = LensProjection::kFieldOfView;
    lens.shape[0] = coefficients[0];
  } else if (name == "none") {
    if (count != 0) ThrowCount(model, count, "none", where);
  } else {
    RefuseModel(model, where);
  }
  return lens;
}

}  // namespace keypose
