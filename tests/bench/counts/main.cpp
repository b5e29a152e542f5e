// Does one piece of work inside of a function that callgrind can be told to count (counts.py):
//   isocaustic_counts           lists them
//   isocaustic_counts NAME      does it, once before it is counted, and prints how much of what it
//   is
#include <iostream>

#include "tests/bench/counts/subject.h"

namespace caustic::bench {

[[gnu::noinline]] void counted(const std::function<void()>& action) {
  action();
  asm volatile("" : : : "memory");  // the call returns to here
}

}  // namespace caustic::bench

int main(int argc, char** argv) {
  using namespace caustic::bench;
  Subjects subjects;
  add_points(subjects);
  add_solver(subjects);
  add_requests(subjects);
  for (const Subject& subject : subjects) {
    if (argc < 2) {
      std::cout << subject.name << '\n';
    } else if (subject.name == argv[1]) {
      const Work work = subject.prepare();
      work.action();  // what is done once in a program's life is done
      counted(work.action);
      std::cout << work.units << ' ' << subject.unit << '\n';
      return 0;
    }
  }
  if (argc < 2) return 0;
  std::cerr << "nothing is called " << argv[1] << '\n';
  return 2;
}
