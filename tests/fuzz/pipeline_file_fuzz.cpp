// A project's pipeline.yaml, including its timeline.
#include "pipeline/graph/pipeline_file.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  return fuzz::Expect(
      [&] { pipeline::ParsePipelineFile(std::string(fuzz::Bytes(data, size)), "pipeline.yaml"); });
}
