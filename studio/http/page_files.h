// The files of the web page, which are part of the program.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace keypose::studio {

struct PageFile {
  std::string name;  ///< "index.html", "studio.js"
  std::string_view bytes;
};

const std::vector<PageFile>& PageFiles();

}  // namespace keypose::studio
