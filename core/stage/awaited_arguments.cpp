#include "core/stage/awaited_arguments.h"

#include <unistd.h>

#include <cerrno>

namespace keypose::internal {

std::vector<std::string> AwaitArguments(int descriptor) {
  constexpr std::size_t kMostBytes = 1 << 20;
  std::string text;
  char buffer[4096];
  while (text.size() < kMostBytes) {
    const ssize_t count = read(descriptor, buffer, sizeof buffer);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    text.append(buffer, static_cast<std::size_t>(count));
  }
  std::vector<std::string> arguments;
  std::size_t begin = 0;
  for (std::size_t end = text.find('\0'); end != std::string::npos; end = text.find('\0', begin)) {
    arguments.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  if (begin != text.size()) return {};
  return arguments;
}

}  // namespace keypose::internal
