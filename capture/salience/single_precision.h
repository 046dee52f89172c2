// A network in half precision, as published, made ready for OpenCV's reader.
#pragma once

#include <string>
#include <string_view>

namespace keypose::capture {

/// Rewrites a network that is stored in half precision (ONNX): all weights become single, and the
/// conversions between the two are taken out; OpenCV 4.6 reads neither half weights nor
/// conversions. Of several outputs only the first is kept, and what only the others need is
/// dropped.
///
/// @param half      the file's bytes: a square input, sizes of `Resize` fixed in constants
/// @param input_px  side of the square input; the sizes of all layers follow. The file's own side,
/// or a part of it by which the smallest layer keeps a whole number of pixels
/// @throws InputError  not such a network
/// Source: the format's definition, onnx.proto, version 1.12.
std::string SinglePrecisionNetwork(std::string_view half, int input_px);

}  // namespace keypose::capture
