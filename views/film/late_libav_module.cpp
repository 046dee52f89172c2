// The module keypose_films: links libav's libraries, in which late_libav.h finds its functions.
extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/avutil.h>
#include <libswresample/swresample.h>
#include <libswscale/swscale.h>
}

/// One function of each: a library of which nothing is used would not be linked.
extern "C" __attribute__((visibility("default"))) unsigned KeyposeFilms() {
  return avcodec_version() + avformat_version() + avutil_version() + swresample_version() +
         swscale_version();
}
