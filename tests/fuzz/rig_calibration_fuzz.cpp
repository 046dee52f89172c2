// Calibrations of fixed cameras: as YAML, TOML, JSON, and as what the content says it is.
#include "core/io/project/rig_calibration.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  const auto bytes = fuzz::Bytes(data, size);
  fuzz::Expect([&] { ReadRigCalibration(fuzz::Put("rig.yaml", bytes)); });
  fuzz::Expect([&] { ReadRigCalibration(fuzz::Put("rig.toml", bytes)); });
  fuzz::Expect([&] { ReadRigCalibration(fuzz::Put("rig.json", bytes)); });
  return fuzz::Expect([&] { OpenCvYaml(ReadRigCalibration(fuzz::Put("rig.txt", bytes)).views); });
}
