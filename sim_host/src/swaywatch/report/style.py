"""The look of swaywatch's HTML pages."""

STYLE = """
:root { color-scheme: light; }
body { font: 15px/1.5 Helvetica, Arial, sans-serif; color: #1f2937; margin: 0; background: #fff; }
main { max-width: 1260px; margin: 0 auto; padding: 24px 28px 60px; }
h1 { font-size: 26px; margin: 0 0 2px; }
h2 { font-size: 20px; margin: 38px 0 6px; border-bottom: 2px solid #e5e7eb; padding-bottom: 4px; }
h3 { font-size: 16px; margin: 26px 0 4px; }
.meta, .note { color: #6b7280; font-size: 13px; }
.verdict { border-left: 8px solid #9ca3af; background: #f9fafb; padding: 12px 18px;
  margin: 14px 0; }
.verdict.good { border-color: #3f9c5b; background: #f0f9f2; }
.verdict.near { border-color: #e3a008; background: #fdf8e7; }
.verdict.bad { border-color: #d64545; background: #fdf0f0; }
.verdict p { font-size: 19px; font-weight: 600; margin: 0; }
.verdict ul { margin: 8px 0 2px; padding-left: 20px; } .verdict li { margin: 3px 0; }
table { border-collapse: collapse; margin: 8px 0 4px; font-size: 14px; }
th, td { text-align: left; padding: 4px 14px 4px 0; border-bottom: 1px solid #e5e7eb;
  vertical-align: top; } th { color: #4b5563; font-weight: 600; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
.error { color: #b91c1c; font-weight: 600; } .warning { color: #b45309; font-weight: 600; }
.info { color: #4b5563; } nav a { margin-right: 16px; }
.state { display: inline-block; padding: 0 8px; border-radius: 3px; }
.modebar { opacity: 0; } .js-plotly-plot:hover .modebar { opacity: 1; }
.state-critical { color: #fff; }
.verdict-word { display: inline-block; padding: 0 8px; border-radius: 3px; white-space: nowrap; }
.verdict-word.good { background: #cdebd5; } .verdict-word.near { background: #f7e6a6; }
.verdict-word.bad { background: #f3c0c0; }
@media print { .js-plotly-plot { break-inside: avoid; } }
"""
