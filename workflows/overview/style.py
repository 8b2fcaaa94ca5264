"""How the overview looks."""

STYLE = """
body { max-width: 1500px; margin: 1em auto; padding: 0 1.5em; }
h1 { font-size: 1.7em; margin: 0.4em 0 0.2em; }
h2 { border-bottom: 2px solid #ddd; padding-bottom: 0.2em; margin-top: 1.8em; }
h3 { margin: 0.8em 0 0.3em; }
a { color: #00578a; }
nav { font-size: 13px; }
nav > ul { columns: 16em; }
nav ul { list-style: none; margin: 0; padding: 0; }
nav li { margin: 0.3em 0; break-inside: avoid; }
nav li ul { padding-left: 1em; }
nav a { text-decoration: none; }
nav a:hover { text-decoration: underline; }
.source { color: #555; font-size: 12.5px; }
.lead { font-size: 1.25em; margin: 0.5em 0; }
#verdict ul { margin: 0; padding: 0; list-style: none; }
#verdict h3 { margin: 0.6em 0 0.2em; }
#verdict li { margin: 0.2em 0; padding-left: 0.7em; border-left: 4px solid #009e73; }
#verdict li { font-size: 13px; line-height: 1.35; }
#verdict .no li { border-color: #d55e00; }
#verdict .in-part li { border-color: #e69f00; }
#verdict .misprint li { border-color: #56b4e9; }
#verdict .not-tested li { border-color: #999; }
#verdict li b { color: #666; font-weight: normal; margin-right: 0.3em; }
#verdict li span { font-size: 11px; }
figure { margin: 1em 0 2.5em; display: grid; gap: 1.5em; align-items: start; }
figure img { border: 1px solid #eee; }
figcaption h3 { margin-top: 0; }
.plain { font-size: 1.1em; }
.paper { border-left: 3px solid #bbb; padding-left: 0.7em; }
section table { font-size: 12.5px; }
tr:target td { background: #fff7d6; }
@media (min-width: 900px) {
  .columns { columns: 2; column-gap: 2em; }
  .columns h3 { break-after: avoid; }
  .columns h3:first-child { margin-top: 0; }
  .columns li { break-inside: avoid; }
  figure { grid-template-columns: 3fr 2fr; }
}
"""
# With the contents beside all else, where there is room.
BESIDE = """
@media (min-width: 1150px) {
  nav { position: fixed; top: 0; bottom: 0; left: max(1.5em, 50vw - 750px); width: 230px; }
  nav { overflow: auto; padding: 1em 0; }
  nav > ul { columns: auto; }
  h1, main { margin-left: 255px; }
}
"""
