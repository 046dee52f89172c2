#include "core/io/pictures/heif_io.h"

#include <libheif/heif.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "core/io/pictures/color_profile.h"
#include "core/values/errors.h"

namespace keypose {

namespace {

void RequireOk(const heif_error& error, const std::filesystem::path& path) {
  if (error.code == heif_error_Ok) return;
  throw InputError("image " + path.string() + " is truncated or damaged (" + error.message +
                   "): copy it from the camera again, or leave it out");
}

template <class T, void (*Free)(T*)>
struct Freed {
  void operator()(T* thing) const { Free(thing); }
};
using Context = std::unique_ptr<heif_context, Freed<heif_context, heif_context_free>>;
struct FreeHandle {
  void operator()(const heif_image_handle* handle) const { heif_image_handle_release(handle); }
};
struct FreePicture {
  void operator()(const heif_image* picture) const { heif_image_release(picture); }
};

/// The colour profile's bytes: the container's own, or of the primaries that it names; empty for
/// sRGB.
std::string ProfileOf(const heif_image_handle* handle) {
  constexpr int kDisplayP3 = 12;  // SMPTE EG 432-1, by ITU-T H.273
  if (const std::size_t size = heif_image_handle_get_raw_color_profile_size(handle); size > 0) {
    std::string bytes(size, '\0');
    return heif_image_handle_get_raw_color_profile(handle, bytes.data()).code == heif_error_Ok
               ? bytes
               : std::string();
  }
  heif_color_profile_nclx* raw = nullptr;
  if (heif_image_handle_get_nclx_color_profile(handle, &raw).code != heif_error_Ok || !raw)
    return {};
  const std::unique_ptr<heif_color_profile_nclx,
                        Freed<heif_color_profile_nclx, heif_nclx_color_profile_free>>
      named(raw);
  return named->color_primaries == kDisplayP3 ? DisplayP3Profile() : std::string();
}

}  // namespace

Image8 ReadHeif(const std::filesystem::path& path) {
  const Context context(heif_context_alloc());
  RequireOk(heif_context_read_from_file(context.get(), path.c_str(), nullptr), path);
  heif_image_handle* raw_handle = nullptr;
  RequireOk(heif_context_get_primary_image_handle(context.get(), &raw_handle), path);
  const std::unique_ptr<heif_image_handle, FreeHandle> handle(raw_handle);
  heif_image* raw_picture = nullptr;
  RequireOk(heif_decode_image(handle.get(), &raw_picture, heif_colorspace_RGB,
                              heif_chroma_interleaved_RGB, nullptr),
            path);
  const std::unique_ptr<heif_image, FreePicture> picture(raw_picture);
  const int width = heif_image_get_width(picture.get(), heif_channel_interleaved),
            height = heif_image_get_height(picture.get(), heif_channel_interleaved);
  int stride = 0;
  const std::uint8_t* rows =
      heif_image_get_plane_readonly(picture.get(), heif_channel_interleaved, &stride);
  if (!rows || width != heif_image_handle_get_width(handle.get()) ||
      height != heif_image_handle_get_height(handle.get()) || stride < 3 * width)
    throw InputError(
        "image " + path.string() +
        " is damaged: its picture does not have the size that its container says; leave it out");
  Image8 image(width, height, 3);
  for (int y = 0; y < height; ++y)
    std::copy_n(rows + static_cast<std::size_t>(y) * stride, 3 * static_cast<std::size_t>(width),
                image.at(0, y));
  return InSrgb(std::move(image), ProfileOf(handle.get()));
}

}  // namespace keypose
