// Names that come out of files: a file from elsewhere must not name what lies elsewhere.
#pragma once

#include <string_view>

namespace keypose {

/// Whether a text names one file or folder: not empty, no '/' and no NUL in it, neither "." nor "..".
bool IsOneName(std::string_view name);

/// Whether a relative path with '/' stays below the folder that it starts from, links aside: each part as above.
bool StaysBelow(std::string_view path);

}  // namespace keypose
