#include "export/caches/testing/run_reader.h"

#include <sys/wait.h>

#include <cstdio>
#include <stdexcept>

namespace keypose::exporting {
namespace {

std::string Quoted(const std::string& word) {
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + '\'';
}

}  // namespace

ReaderResult RunReader(const std::vector<std::string>& words, int seconds) {
  std::string command = "timeout " + std::to_string(seconds);
  for (const std::string& word : words) command += ' ' + Quoted(word);
  FILE* pipe = popen((command + " 2>&1 < /dev/null").c_str(), "r");
  if (!pipe) throw std::runtime_error("cannot start " + words[0]);
  ReaderResult result;
  char buffer[4096];
  for (std::size_t count = 0; (count = fread(buffer, 1, sizeof buffer, pipe)) > 0;)
    result.output.append(buffer, count);
  const int status = pclose(pipe);
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return result;
}

bool HasReader(const std::string& program) {
  return RunReader({"sh", "-c", "command -v " + Quoted(program)}, 10).exit_code == 0;
}

double FigureOf(const std::string& output, const std::string& name) {
  const auto at = output.find(name + '=');
  if (at == std::string::npos) throw std::runtime_error("no " + name + " in: " + output);
  return std::stod(output.substr(at + name.size() + 1));
}

}  // namespace keypose::exporting
