#include "validate/report.h"

#include "atlas/atomic_file.h"
#include "validate/report_parts.h"

namespace pluvia {

void write_report(const std::string& folder, const Report& report) {
  // Both texts before the first file: a report that is refused leaves the old pair as it was.
  const std::string json = report_json(report);
  const std::string page = report_page(report, folder);
  make_folder(folder);
  write_file_atomically(folder + "/report.json", json);
  write_file_atomically(folder + "/index.html", page);
}

}  // namespace pluvia
