#include "studio/runs/warm_program.h"

#include <utility>

#include "core/values/errors.h"

namespace keypose::studio {

WarmProgram::WarmProgram(std::filesystem::path program, std::filesystem::path folder)
    : program_(std::move(program)), folder_(std::move(folder)) {}

WarmProgram::Waiting WarmProgram::Start() const {
  const std::vector<std::string> words = {program_.string(), "--await"};
  std::error_code unknown;
  return {std::make_unique<PipedChild>(words, folder_),
          std::filesystem::last_write_time(program_, unknown)};
}

void WarmProgram::Warm() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!waiting_.child) waiting_ = Start();
}

WarmProgram::Waiting WarmProgram::Take() {
  Waiting taken;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::swap(taken, waiting_);
  }
  std::error_code unknown;
  if (taken.child && taken.written == std::filesystem::last_write_time(program_, unknown))
    return taken;
  return Start();
}

ChildResult WarmProgram::Run(const std::vector<std::string>& arguments, double seconds) {
  std::string text;
  for (const std::string& argument : arguments) text += argument + '\0';
  ChildResult result = Take().child->Finish(text, seconds);
  try {
    Warm();
  } catch (const Error&) {
    // The answer is there; whoever asks next starts a program and hears why it does not start.
  }
  return result;
}

}  // namespace keypose::studio
