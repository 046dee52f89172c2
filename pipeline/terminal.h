// The terminal that standard output may be.
#pragma once

#include <cstddef>
#include <string_view>

namespace keypose::pipeline {

bool OnTerminal();
/// Columns of the terminal; 0 when standard output is a file or a pipe.
std::size_t TerminalColumns();

/// Writes to standard output at once. What is at its other end may be gone (`keypose run | head`):
/// a run goes on without it.
void Say(std::string_view text);

}  // namespace keypose::pipeline
