#include "pipeline/text/terminal.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>

namespace keypose::pipeline {

bool OnTerminal() { return isatty(STDOUT_FILENO) == 1; }

std::size_t TerminalColumns() {
  if (!OnTerminal()) return 0;
  winsize size{};
  return ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 20 ? size.ws_col : 80;
}

void Say(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stdout);
  std::fflush(stdout);
}

}  // namespace keypose::pipeline
