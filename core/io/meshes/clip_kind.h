// What a file that shall be a motion clip is, judged by its first bytes, and its text.
#pragma once

#include <string>
#include <string_view>

namespace keypose {

/// What a clip is that is no BVH file, with the cure, as "is FBX; ..."; empty: it may be one.
std::string OtherClip(std::string_view bytes);

}  // namespace keypose
