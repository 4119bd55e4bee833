// Workspaces of const functions that several threads may call concurrently.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <utility>

namespace saltus {

namespace detail {

/// Which threads may call lend().
enum class Lending {
  shared,    ///< any number of threads concurrently
  exclusive  ///< one thread at a time; never allocates
};

/// Keeps workspaces between calls and lends each to one call at a time. lend() is lock-free. With
/// shared lending, it allocates if no workspace was added or all are in use.
template <class T>
class WorkspacePool {
 public:
  /// Exclusive lending requires one call of add().
  explicit WorkspacePool(Lending lending = Lending::shared) : lending_(lending) {}
  WorkspacePool(const WorkspacePool&) = delete;
  WorkspacePool& operator=(const WorkspacePool&) = delete;
  ~WorkspacePool() {
    for (std::atomic<T*>& slot : kept_) delete slot.load(std::memory_order_relaxed);
  }

  /// Owns a workspace during its lifetime. The destructor returns the workspace to the pool, also
  /// after an exception.
  class Loan {
   public:
    /// `back` is the pool that gets the workspace back; null for exclusive lending.
    Loan(const WorkspacePool* back, T* workspace) : back_(back), workspace_(workspace) {}
    ~Loan() {
      if (back_ != nullptr) back_->keep(std::unique_ptr<T>(workspace_));
    }
    Loan(const Loan&) = delete;
    Loan& operator=(const Loan&) = delete;
    /// The workspace.
    T& operator*() const { return *workspace_; }
    /// The workspace.
    T* operator->() const { return workspace_; }

   private:
    const WorkspacePool* back_;  // null: the pool still owns it
    T* workspace_;
  };

  /// True if several threads may borrow concurrently.
  bool is_shared() const { return lending_ == Lending::shared; }
  /// Adds a workspace. Call it in a constructor, where all sizes are known. lend() then does not
  /// allocate for a single thread.
  void add(std::unique_ptr<T> workspace) { keep(std::move(workspace)); }

  /// Lends a workspace that no other call uses. make() returns a new one as std::unique_ptr<T>.
  template <class Make>
  Loan lend(const Make& make) const {
    if (!is_shared()) return {nullptr, kept_.front().load(std::memory_order_relaxed)};
    for (std::atomic<T*>& slot : kept_)
      if (T* const free = slot.exchange(nullptr, std::memory_order_acquire)) return {this, free};
    return {this, make().release()};
  }

 private:
  static constexpr int max_kept_workspaces = 4;  // further concurrent threads allocate

  void keep(std::unique_ptr<T> workspace) const {
    for (std::atomic<T*>& slot : kept_) {
      T* none = nullptr;
      if (!slot.compare_exchange_strong(none, workspace.get(), std::memory_order_release,
                                        std::memory_order_relaxed))
        continue;
      (void)workspace.release();  // the slot owns it now
      return;
    }
  }

  Lending lending_;
  mutable std::array<std::atomic<T*>, max_kept_workspaces> kept_{};
};

}  // namespace detail

}  // namespace saltus
