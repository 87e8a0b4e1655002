# Bounds that the .idl files state and fastddsgen's code does not check, and the texts of messages. Two uses:
#
#   awk -v mode=functions -f bounds.awk *.idl                 bounds_violation() of every type, as a header
#   awk -v mode=reads     -f bounds.awk *.idl SUBJECT.cxx     SUBJECT.cxx with a check before each sequence is read, and
#                                                             of each text that is read or written
#
# A type more, or a sequence or a text more, needs nothing here. One that is not found in the generated code ends with
# an error: a change of the generator must not take the check away. A text is one line, unless its name ends in _toml.

FNR == 1 { is_generated = FILENAME ~ /\.cxx$/ }

!is_generated {
  sub(/\/\/.*/, "")
  rest = rest " " $0
  # One statement or brace at a time: what follows waits for the next line.
  while (match(rest, /[;{}]/)) {
    statement = substr(rest, 1, RSTART - 1)
    mark = substr(rest, RSTART, 1)
    rest = substr(rest, RSTART + 1)
    gsub(/@[a-z]+/, "", statement)
    gsub(/[ \t]+/, " ", statement)
    gsub(/^ | $/, "", statement)
    if (mark == "{" && statement ~ /^struct /) {
      type = substr(statement, 8)
      types[++type_count] = type
      fields[type] = 0
    } else if (mark == "{" && statement ~ /^enum /) {
      enumeration = substr(statement, 6)
    } else if (mark == "}" && enumeration != "") {
      count = split(statement, names, ",")
      last = names[count]
      gsub(/ /, "", last)
      last_of[enumeration] = last
      enumeration = ""
    } else if (mark == "}") {
      type = ""
    } else if (mark == ";" && type != "" && statement != "") {
      n = ++fields[type]
      element[type, n] = statement
      sub(/ [A-Za-z0-9_]+(\[[0-9]+\])?$/, "", element[type, n])
      name = substr(statement, length(element[type, n]) + 2)
      is_array[type, n] = sub(/\[[0-9]+\]$/, "", name)
      field[type, n] = name
      if (element[type, n] ~ /^sequence/) {
        if (element[type, n] !~ /,/) fatal("sequence " type "." name " has no bound")
        bound[type, n] = element[type, n]
        sub(/^.*, */, "", bound[type, n])
        sub(/ *>.*$/, "", bound[type, n])
        sub(/^sequence *< */, "", element[type, n])
        sub(/ *,.*$/, "", element[type, n])
        bound_of[type, name] = bound[type, n]
      }
      if (element[type, n] == "string") {
        is_text[type, name] = 1
        kind[type, name] = name ~ /_toml$/ ? "::tonus::TextKind::kFile" : "::tonus::TextKind::kLine"
        if ((type, name) in bound_of && name ~ /_toml$/) fatal("a sequence of files: " type "." name)
      }
    }
  }
  next
}

# Generated code. A function's first line names the type that it belongs to.
FNR == 1 { print "#include \"idl/bounded_read.hpp\"" }
match($0, /^void [A-Za-z0-9_:]+::(de)?serialize\(/) {
  within = substr($0, 6, RLENGTH - 5)
  sub(/::(de)?serialize\($/, "", within)
  sub(/^.*::/, "", within)
  is_read[within] = 1
}
/^}/ { within = "" }
within != "" && match($0, /m_[A-Za-z0-9_]+;$/) && /dcdr >> m_/ {
  name = substr($0, RSTART + 2, RLENGTH - 3)
  if ((within, name) in bound_of) {
    print "    ::tonus::v1::require_length_ahead(dcdr, " bound_of[within, name] ");"
    is_checked[within, name] = 1
  }
}
within != "" && match($0, /m_[A-Za-z0-9_]+\.resize\(seq_length\);/) {
  name = substr($0, RSTART + 2, index(substr($0, RSTART), ".") - 3)
  if ((within, name) in bound_of) {
    print "        ::tonus::v1::require_length(seq_length, " bound_of[within, name] ");"
    is_checked[within, name] = 1
  } else {
    fatal("resize of " within "." name " is not known")
  }
}
within != "" && match($0, /scdr << m_[A-Za-z0-9_]+(\.c_str\(\))?;$/) {
  name = substr($0, RSTART + 10)
  sub(/(\.c_str\(\))?;$/, "", name)
  if ((within, name) in is_text) {
    print "    scdr << ::tonus::v1::written_text(m_" name ", " kind[within, name] ")" \
          ((within, name) in bound_of ? ";" : ".c_str();")
    is_written[within, name] = 1
    next
  }
}
{ print }
within != "" && match($0, /dcdr >> m_[A-Za-z0-9_]+;$/) {
  name = substr($0, RSTART + 10, RLENGTH - 11)
  if ((within, name) in is_text) {
    if ((within, name) in bound_of) print "    ::tonus::v1::take_texts(dcdr, m_" name ");"
    else print "    ::tonus::v1::take_text(dcdr, m_" name ", " kind[within, name] ");"
    is_taken[within, name] = 1
  }
}

function fatal(text) {
  print "bounds.awk: " text > "/dev/stderr"
  has_failed = 1
  exit 1
}

function print_functions(   i, n, what, lines, type) {
  print "// Made by idl/bounds.awk from the .idl files."
  print "#pragma once\n\nnamespace tonus::v1 {\n"
  for (i = 1; i <= type_count; ++i) {
    type = types[i]
    lines = ""
    for (n = 1; n <= fields[type]; ++n) {
      what = "\"" type "." field[type, n] "\""
      if ((type, n) in bound) {
        lines = lines "  if (value." field[type, n] "().size() > " bound[type, n] ")\n" \
                "    return out_of_bounds(" what ", value." field[type, n] "().size(), " bound[type, n] ");\n"
        if (element[type, n] in last_of) {
          lines = lines "  for (const auto item : value." field[type, n] "()) {\n" \
                  "    if (item > " last_of[element[type, n]] ") return out_of_bounds(" what ", item, " \
                  last_of[element[type, n]] ");\n  }\n"
        } else if (element[type, n] in has_function) {
          lines = lines "  for (const auto& item : value." field[type, n] "()) {\n" \
                  "    if (std::string inner = bounds_violation(item); !inner.empty()) return inner;\n  }\n"
        }
      } else if (element[type, n] in last_of) {
        if (is_array[type, n]) fatal("array of enumerators " type "." field[type, n])
        lines = lines "  if (value." field[type, n] "() > " last_of[element[type, n]] ")\n" \
                "    return out_of_bounds(" what ", value." field[type, n] "(), " last_of[element[type, n]] ");\n"
      } else if (element[type, n] in has_function) {
        lines = lines "  if (std::string inner = bounds_violation(value." field[type, n] \
                "()); !inner.empty()) return inner;\n"
      }
    }
    if (lines == "") continue
    has_function[type] = 1
    print "[[nodiscard]] inline std::string bounds_violation(const " type "& value) {"
    printf "%s", lines
    print "  return {};\n}\n"
  }
  print "}  // namespace tonus::v1"
}

END {
  if (has_failed) exit 1
  if (mode == "functions") {
    print_functions()
  } else {
    for (key in bound_of) {
      split(key, parts, SUBSEP)
      if (is_read[parts[1]] && !is_checked[key]) fatal("sequence " parts[1] "." parts[2] " is read without a check")
    }
    for (key in is_text) {
      split(key, parts, SUBSEP)
      if (is_read[parts[1]] && !(is_taken[key] && is_written[key]))
        fatal("text " parts[1] "." parts[2] " is read or written without a check")
    }
  }
  if (has_failed) exit 1
}
