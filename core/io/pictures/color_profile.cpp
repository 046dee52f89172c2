#include "core/io/pictures/color_profile.h"

#include <lcms2.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <utility>
#include <vector>

namespace keypose {
namespace {

struct CloseProfile {
  void operator()(void* profile) const { cmsCloseProfile(profile); }
};
struct DeleteTransform {
  void operator()(void* transform) const { cmsDeleteTransform(transform); }
};
struct FreeCurve {
  void operator()(cmsToneCurve* curve) const { cmsFreeToneCurve(curve); }
};
using Profile = std::unique_ptr<void, CloseProfile>;
using Transform = std::unique_ptr<void, DeleteTransform>;

/// Null where it cannot be used.
/// @param format  of Little CMS, of both pictures
Transform ToSrgb(const std::string& bytes, cmsUInt32Number format, cmsUInt32Number flags) {
  // Damaged profiles are common, and pictures with one are taken for sRGB as by browsers.
  cmsSetLogErrorHandler(nullptr);
  const Profile from(
      cmsOpenProfileFromMem(bytes.data(), static_cast<cmsUInt32Number>(bytes.size())));
  if (!from || cmsGetColorSpace(from.get()) != cmsSigRgbData) return nullptr;
  const Profile to(cmsCreate_sRGBProfile());
  // Without its cache a transform may be used by several threads.
  return Transform(cmsCreateTransform(from.get(), format, to.get(), format,
                                      INTENT_RELATIVE_COLORIMETRIC, cmsFLAGS_NOCACHE | flags));
}

/// Whether the transform moves no level of a lattice of colours by more than one.
bool ChangesNothing(void* transform) {
  constexpr int kStep = 51;
  std::vector<std::uint8_t> from;
  for (int r = 0; r < 256; r += kStep)
    for (int g = 0; g < 256; g += kStep)
      for (int b = 0; b < 256; b += kStep)
        for (const int level : {r, g, b}) from.push_back(static_cast<std::uint8_t>(level));
  std::vector<std::uint8_t> to(from.size());
  cmsDoTransform(transform, from.data(), to.data(), static_cast<cmsUInt32Number>(from.size() / 3));
  return std::equal(from.begin(), from.end(), to.begin(),
                    [](int a, int b) { return std::abs(a - b) <= 1; });
}

template <class T>
void Apply(void* transform, ImageT<T>* image) {
  for (int y = 0; y < image->height; ++y)
    cmsDoTransform(transform, image->at(0, y), image->at(0, y),
                   static_cast<cmsUInt32Number>(image->width));
}

/// The transform of 8 bits; null where the picture is to stay as it is.
template <class T>
Transform Needed(const ImageT<T>& image, const std::string& profile) {
  if (profile.empty() || image.channels != 3 || image.empty()) return nullptr;
  Transform transform = ToSrgb(profile, TYPE_RGB_8, 0);
  return transform && !ChangesNothing(transform.get()) ? std::move(transform) : nullptr;
}

}  // namespace

Image8 InSrgb(Image8 image, const std::string& profile) {
  if (const Transform transform = Needed(image, profile)) Apply(transform.get(), &image);
  return image;
}

Image16 InSrgb(Image16 image, const std::string& profile) {
  if (!Needed(image, profile)) return image;
  // Of 16 bits, Little CMS makes a table of colours, which is off by up to 3900 steps (measured).
  if (const Transform transform = ToSrgb(profile, TYPE_RGB_16, cmsFLAGS_NOOPTIMIZE))
    Apply(transform.get(), &image);
  return image;
}

std::string ProfileOf(const double (&red)[2], const double (&green)[2], const double (&blue)[2]) {
  const cmsCIExyY white{0.3127, 0.3290, 1};
  const cmsCIExyYTRIPLE primaries{
      {red[0], red[1], 1}, {green[0], green[1], 1}, {blue[0], blue[1], 1}};
  // sRGB's curve, IEC 61966-2-1.
  const cmsFloat64Number parameters[] = {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};
  const std::unique_ptr<cmsToneCurve, FreeCurve> curve(
      cmsBuildParametricToneCurve(nullptr, 4, parameters));
  cmsToneCurve* curves[] = {curve.get(), curve.get(), curve.get()};
  const Profile profile(cmsCreateRGBProfile(&white, &primaries, curves));
  cmsUInt32Number size = 0;
  if (!profile || !cmsSaveProfileToMem(profile.get(), nullptr, &size)) return {};
  std::string bytes(size, '\0');
  if (!cmsSaveProfileToMem(profile.get(), bytes.data(), &size)) return {};
  return bytes;
}

std::string DisplayP3Profile() { return ProfileOf({0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}); }

}  // namespace keypose
