#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

#include "srslam/io/tum_dataset.hpp"

namespace srslam {

/// A ring of frames: the worker fills the slot behind the last ready one, next() takes the first.
struct FrameReader::Impl {
  Impl(const TumDataset& dataset_in, const RgbdCamera& camera_in, std::size_t first_index,
       std::size_t last_index, std::size_t read_ahead)
      : dataset(dataset_in),
        camera(camera_in),
        first(first_index),
        end_index(std::max(first_index, std::min(last_index, dataset_in.size()))),
        slots(std::min(read_ahead, end_index - first_index)) {
    if (slots.empty()) return;
    try {
      worker = std::thread([this] { decode_ahead(); });
    } catch (const std::system_error&) {
      slots.clear();
    }
  }

  ~Impl() {
    {
      const std::lock_guard<std::mutex> lock(mutex);
      stopping = true;
    }
    slot_free.notify_one();
    if (worker.joinable()) worker.join();
  }

  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void decode_ahead() {
    std::size_t slot = 0;
    for (std::size_t index = first; index < end_index; ++index) {
      {
        std::unique_lock<std::mutex> lock(mutex);
        slot_free.wait(lock, [this] { return stopping || num_ready < slots.size(); });
        if (stopping) return;
      }
      // Not ready yet, so next() does not look at this slot.
      dataset.load(index, camera, &slots[slot]);
      slot = (slot + 1) % slots.size();
      {
        const std::lock_guard<std::mutex> lock(mutex);
        ++num_ready;
      }
      frame_ready.notify_one();
    }
  }

  bool next(LoadedFrame* frame) {
    if (num_taken == end_index - first) return false;
    if (slots.empty()) {
      dataset.load(first + num_taken, camera, frame);
      ++num_taken;
      return true;
    }
    {
      std::unique_lock<std::mutex> lock(mutex);
      frame_ready.wait(lock, [this] { return num_ready > 0; });
      std::swap(*frame, slots[num_taken % slots.size()]);
      --num_ready;
    }
    ++num_taken;
    slot_free.notify_one();
    return true;
  }

  const TumDataset& dataset;
  const RgbdCamera camera;
  const std::size_t first;
  const std::size_t end_index;
  std::size_t num_taken = 0;  ///< touched by the caller's thread only
  std::vector<LoadedFrame> slots;
  std::mutex mutex;
  std::condition_variable slot_free;
  std::condition_variable frame_ready;
  std::size_t num_ready = 0;  ///< guarded by mutex
  bool stopping = false;      ///< guarded by mutex
  std::thread worker;         ///< last, so that it sees the rest initialised
};

FrameReader::FrameReader(const TumDataset& dataset, const RgbdCamera& camera,
                         std::size_t first_index, std::size_t last_index, std::size_t read_ahead)
    : impl_(std::make_unique<Impl>(dataset, camera, first_index, last_index, read_ahead)) {}

FrameReader::~FrameReader() = default;

bool FrameReader::next(LoadedFrame* frame) { return impl_->next(frame); }

}  // namespace srslam
