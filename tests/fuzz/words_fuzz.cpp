// What people name boards and numbered pictures: the first line is a board, each other one a name.
#include <sstream>

#include "core/io/project/frame_names.h"
#include "core/values/board_print.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  std::istringstream lines{std::string(fuzz::Bytes(data, size))};
  std::string board, name;
  std::getline(lines, board);
  std::vector<std::string> names;
  while (std::getline(lines, name)) names.push_back(name);
  const FrameNumbering numbering = NumberNames(names);
  if (numbering.fault.empty() && numbering.numbers.size() != names.size()) std::abort();
  return fuzz::Expect([&] { ParseBoard(board); });
}
