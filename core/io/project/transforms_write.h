// transforms.json for other programs, as nerfstudio describes it ("Data conventions").
#pragma once

#include <string>
#include <vector>

#include "core/values/camera.h"

namespace keypose {

/// What belongs to a view, as paths from the file's folder.
struct TransformsFrame {
  std::string image, mask;
};

/// The text of a transforms.json: camera-to-world matrices with x right, y up and z backwards, in
/// the views' own world; each frame has its own intrinsics (OPENCV's), which stand in the head too
/// where all are the same, for programs that look only there. Pixel centres at .5.
/// @param frames  one for each view
/// @param points  path of a PLY file with sparse points; empty: none
/// @throws InputError  a name that is not UTF-8, which JSON cannot hold
std::string TransformsText(const std::vector<View>& views,
                           const std::vector<TransformsFrame>& frames, const std::string& points);

/// Sparse points with colours as an ASCII PLY of floats, which programs of splats start from.
std::string SparsePlyText(const std::vector<SparsePoint>& points);

}  // namespace keypose
