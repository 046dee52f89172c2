// Standard output and its terminal.
#pragma once

#include <cstddef>
#include <string_view>

namespace keypose::pipeline {

bool OnTerminal();
/// Columns of the terminal; 0 when standard output is a file or a pipe.
std::size_t TerminalColumns();

/// Writes to standard output without buffering. Ignores a closed pipe (`keypose run | head`), so
/// that the run goes on.
void Say(std::string_view text);

}  // namespace keypose::pipeline
