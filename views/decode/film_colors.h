// What the numbers of a film's pictures mean as colours, by what its frames say of themselves.
#pragma once

extern "C" {
#include <libavutil/frame.h>
}

#include <string>

namespace keypose {

/// R' = (Y - black) scale + r_of_v V, and so on, with V and U = (value - middle) chroma_scale;
/// scales make 255 of white.
struct YuvWeights {
  double black = 0, middle = 0, scale = 1, chroma_scale = 1;
  double r_of_v = 0, g_of_u = 0, g_of_v = 0, b_of_u = 0;
};

/// The weights of a frame of Y'CbCr. A matrix that is not said is BT.709 above 576 rows or 1279
/// columns, else BT.601, as players do; a range that is not said is limited.
/// Source: ITU-R BT.601-7, BT.709-6, BT.2020-2; ISO/IEC 23091-2 for the codes.
YuvWeights WeightsOf(const AVFrame& frame);

/// Why the frame's colours cannot be read, with a cure; empty: they can.
std::string ColorFault(const AVFrame& frame);

/// Words on colours that are read as if they were sRGB's, though wider; empty: they are not.
std::string ColorNote(const AVFrame& frame);

}  // namespace keypose
