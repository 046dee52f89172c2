// Timelines.
#include "core/io/project/timeline_json.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  return fuzz::Expect(
      [&] { ParseTimeline(std::string(fuzz::Bytes(data, size)), "timeline.json"); });
}
