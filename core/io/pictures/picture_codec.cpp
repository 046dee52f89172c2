#include "core/io/pictures/picture_codec.h"

#include "core/values/late_library.h"

namespace keypose {
namespace {

LateLibrary picture_library("pictures", "KeyposePictures", "read and write pictures");

}  // namespace

const PictureCodec& Pictures() {
  using Entry = const PictureCodec* (*)();
  return *reinterpret_cast<Entry>(picture_library.Entry())();
}

}  // namespace keypose
