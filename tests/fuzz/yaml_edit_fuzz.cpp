// Changes of single values in a YAML file. The first line names the place, "options dense levels",
// the second the value; what follows is the file.
#include "core/io/text/yaml_edit.h"

#include <sstream>

#include "tests/fuzz/fuzz_folder.h"

namespace {

using namespace keypose;

/// What cannot be changed safely is refused.
template <class Edit>
void Try(const Edit& edit) {
  try {
    edit();
  } catch (const YamlEditError&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::istringstream input{std::string(fuzz::Bytes(data, size))};
  std::string place, value, key;
  if (!std::getline(input, place) || !std::getline(input, value)) return 0;
  YamlPath path;
  for (std::istringstream words(place); words >> key;) path.push_back(key);
  if (path.empty()) return 0;
  const std::string text(std::istreambuf_iterator<char>(input), {});
  Try([&] { WithValue(text, path, value); });
  Try([&] { WithoutValue(text, path); });
  Try([&] { WithItems(text, path, {value, "{pose: rest}"}); });
  Try([&] { WithListUnder(text, path, YamlScalar(value)); });
  return 0;
}
