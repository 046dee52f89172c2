// Shows a run: bars on a terminal, plain lines elsewhere, JSON lines for programs.
#pragma once

#include <memory>
#include <string>

#include "pipeline/disk/clock.h"
#include "pipeline/run/observer.h"

namespace keypose::pipeline {

enum class DisplayKind { kBars, kLines, kJsonLines };

/// Writes to standard output.
std::unique_ptr<RunObserver> MakeDisplay(DisplayKind kind, const Clock& clock);

}  // namespace keypose::pipeline
