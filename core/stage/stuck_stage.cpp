// A stage for tests that stands in a call which looks at nothing, with its output half written.
#include <unistd.h>

#include "core/io/text/files.h"
#include "core/stage/stage.h"

namespace {

using namespace keypose;

struct NoOptions {
  void Describe(OptionVisitor&) {}
};

/// Writes "stuck" beside its input once it has begun, then waits for five minutes.
void WriteHalfAndWait(StageContext& stage, const NoOptions&) {
  WriteFile(stage.Output("copy"), "half");
  WriteFile(stage.Scratch() / "left.bin", "half");
  WriteFile(std::filesystem::path(stage.Input("text")).parent_path() / "stuck", "");
  for (int i = 0; i < 3000; ++i) usleep(100000);
}

}  // namespace

int main(int argc, char** argv) {
  const StageSpec spec{"stuck",
                       "1",
                       "Waits.",
                       "Waiting",
                       {},
                       {{"text", "file", "what to copy", ""}},
                       {{"copy", "file", "the copy", "copy.txt"}},
                       {},
                       {},
                       1,
                       0.1};
  return RunStage<NoOptions>(argc, argv, spec, WriteHalfAndWait);
}
