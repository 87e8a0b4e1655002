# Reads a session in R: the CSV files of `tonus export --format csv` with base R alone, and, where RSQLite is
# installed, the archive itself.
#
# Usage: Rscript read_session.R CSV_FOLDER [ARCHIVE]

arguments <- commandArgs(trailingOnly = TRUE)
folder <- arguments[1]

trials <- read.csv(file.path(folder, "trials.csv"))
samples <- read.csv(file.path(folder, "samples", sprintf("trial-%d.csv", trials$attempt[1])))
estimates <- read.csv(file.path(folder, "estimates.csv"))
cat(sprintf("%d trials, %d count; trial %d has %d samples\n", nrow(trials), sum(trials$valid == "true"),
            trials$attempt[1], nrow(samples)))
stiffness <- subset(estimates, quantity == "K" & row == 1 & column == 1)
cat(sprintf("%s: K(1,1) = %.10g %s\n", stiffness$posture, stiffness$value, stiffness$unit), sep = "")

if (length(arguments) > 1 && requireNamespace("RSQLite", quietly = TRUE)) {
  archive <- DBI::dbConnect(RSQLite::SQLite(), arguments[2], flags = RSQLite::SQLITE_RO)
  counts <- DBI::dbGetQuery(archive, "SELECT posture, count(*) AS trials, sum(missing_samples) AS missing
                                      FROM trials GROUP BY posture ORDER BY posture")
  print(counts)
  DBI::dbDisconnect(archive)
}
