// The runner's files below .keypose, and the output of --describe; the first letter selects the
// kind.
#include <nlohmann/json.hpp>

#include "pipeline/cache/artifact_store.h"
#include "pipeline/cache/content_hasher.h"
#include "pipeline/cache/records.h"
#include "pipeline/graph/stage_info.h"
#include "pipeline/run/results_folder.h"
#include "pipeline/testing/memory_disk.h"
#include "tests/fuzz/fuzz_folder.h"

namespace {

using namespace keypose;
using namespace keypose::pipeline;

/// Gives a manifest the fingerprint of its recipe, which a fuzzer cannot guess.
void LookAtManifest(MemoryDisk& disk, const std::string& text) {
  nlohmann::json manifest = nlohmann::json::parse(text, nullptr, false);
  std::string fingerprint(64, '0');
  try {
    fingerprint = RecipeFromJson(manifest.at("recipe")).Fingerprint();
    manifest["fingerprint"] = fingerprint;
  } catch (const nlohmann::json::exception&) {
  }
  ArtifactStore store(disk, "/state");
  disk.Write(store.FolderOf(fingerprint) / "manifest.json",
             manifest.is_discarded()
                 ? text
                 : manifest.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  disk.Write(store.FolderOf(fingerprint) / "text/a", "a");
  std::string damage;
  store.Find(fingerprint, &damage);
  store.Verify(fingerprint);
}

void LookAtResults(MemoryDisk& disk, const std::string& text) {
  disk.Write("/state/out.json", text);
  disk.Write("/project/out/a", "a");
  ResultsFolder results(disk, "/project/out", "/state/out.json");
  results.Verify();
  results.DropStepsOutside(Graph{});
  results.Save();
}

void LookAtHashes(MemoryDisk& disk, const std::string& text) {
  disk.Write("/state/hashes.json", text);
  disk.Write("/project/a", "a");
  ContentHasher hasher(disk, "/state/hashes.json", "/project");
  hasher.Of("/project/a");
  hasher.Save();
}

void LookAtRecords(MemoryDisk& disk, const std::string& text) {
  disk.Write("/state/steps/mesh.json", text);
  disk.Write("/state/runs/1.json", text);
  Records records(disk, "/state");
  if (const auto last = records.Last("mesh")) records.SetLast("mesh", *last);
  records.Mentioned(1, {"mesh"});
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string text(fuzz::Bytes(data + 1, size - 1));
  MemoryDisk disk;
  return fuzz::Expect([&] {
    switch (data[0]) {
      case 'm':
        return LookAtManifest(disk, text);
      case 'o':
        return LookAtResults(disk, text);
      case 'h':
        return LookAtHashes(disk, text);
      case 'r':
        return LookAtRecords(disk, text);
      case 'd':
        ParseStageInfo(text, "keypose-mesh");
        return;
    }
  });
}
