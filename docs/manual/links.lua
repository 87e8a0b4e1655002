-- Links between pages: the sources name .md files, the built pages .html ones.
function Link(link)
  if not link.target:match("^%a+://") then
    link.target = link.target:gsub("%.md$", ".html"):gsub("%.md#", ".html#")
  end
  return link
end
