// The pipeline.yaml of a new project.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace keypose::pipeline {

/// Names the project after its folder. Each pose's photographs are in photos/POSE; with two poses
/// or more, the timeline shows them in this order.
std::string NewPipelineText(const std::filesystem::path& folder,
                            const std::vector<std::string>& poses,
                            const std::string& template_pose);

}  // namespace keypose::pipeline
