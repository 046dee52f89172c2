#include "core/io/pictures/picture_codec.h"

#include "core/values/late_library.h"

namespace keypose {
namespace {

LateLibrary picture_library("pictures", "read and write pictures");

}  // namespace

const PictureCodec& Pictures() {
  using Entry = const PictureCodec* (*)();
  static const PictureCodec& codec =
      *reinterpret_cast<Entry>(picture_library.Find("KeyposePictures"))();
  return codec;
}

}  // namespace keypose
