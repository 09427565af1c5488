// UpdateGate: notices, in builds with debug checks, queries that overlap an update of what they
// look at. Without these checks it is empty.
#pragma once

#include <atomic>

#include "sinew/base/check.h"

namespace sinew {

class UpdateGate {
 public:
  class Query {
   public:
    explicit Query(const UpdateGate& gate) : gate_(gate) { gate_.enter(1); }
    ~Query() { gate_.leave(1); }
    Query(const Query&) = delete;
    Query& operator=(const Query&) = delete;

   private:
    const UpdateGate& gate_;
  };
  class Update {
   public:
    explicit Update(const UpdateGate& gate) : gate_(gate) { gate_.enter(kUpdate); }
    ~Update() { gate_.leave(kUpdate); }
    Update(const Update&) = delete;
    Update& operator=(const Update&) = delete;

   private:
    const UpdateGate& gate_;
  };

 private:
  static constexpr int kUpdate = 1 << 20;  // more than queries that run at a time

#ifdef NDEBUG
  void enter(int) const {}
  void leave(int) const {}
#else
  void enter(int who) const {
    const int before = inside_.fetch_add(who);
    SINEW_DCHECK(who == kUpdate ? before == 0 : before < kUpdate);  // an update overlaps a query
  }
  void leave(int who) const {
    inside_.fetch_sub(who);
  }
  mutable std::atomic<int> inside_ = 0;
#endif
};

}  // namespace sinew
