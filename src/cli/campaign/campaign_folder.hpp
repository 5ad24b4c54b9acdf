#pragma once

#include <string>

namespace srslam::cli {

/// Lets one campaign at a time work in a folder. The lock is freed when the process ends, however
/// that happens.
class CampaignLock {
 public:
  CampaignLock() = default;
  ~CampaignLock();
  CampaignLock(const CampaignLock&) = delete;
  CampaignLock& operator=(const CampaignLock&) = delete;

  /// Takes the lock of `folder`. Returns an empty string, or who has it.
  std::string acquire(const std::string& folder);

 private:
  int descriptor_ = -1;
};

/// Makes an empty hidden folder in `parent` (which is made too) for something that is renamed to
/// its place when it is complete. Its name has `label`, the host and the process, so that no other
/// process on any machine uses it. Returns an empty string or the reason.
std::string make_work_folder(const std::string& parent, const std::string& label,
                             std::string* folder);

/// Gives a complete work folder its final name. When something of that name is there, another
/// process was faster: the work is dropped, unless `replaces`. Returns an empty string or the
/// reason.
std::string publish_folder(const std::string& work_folder, const std::string& final_folder,
                           bool replaces);

/// Removes work folders in `parent` that processes of this machine left when they were killed.
void remove_abandoned_work(const std::string& parent);

}  // namespace srslam::cli
