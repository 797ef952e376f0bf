"""The style of the pages: one sheet, inlined; light and dark after the reader's setting, and fit for printing."""

CSS = """
:root{color-scheme:light dark;--paper:#fcfcfa;--ink:#1c1e21;--soft:#5f646b;--line:#e2e2dc;--card:#f3f3ef;
--accent:#0b66a8;--alarm:#a63c06;--alarm-card:#fdf1e7;--s0:#0b66a8;--s1:#c8501e;--s2:#2c8a57;--s3:#8a4fae;--s4:#b3840f;--s5:#5f646b}
@media(prefers-color-scheme:dark){:root{--paper:#15171a;--ink:#e7e7e3;--soft:#9aa0a8;--line:#2e3238;--card:#1e2125;--accent:#6db6ee;
--alarm:#f4a873;--alarm-card:#2d2119;--s0:#6db6ee;--s1:#f0875a;--s2:#63c48f;--s3:#c395e2;--s4:#e0b955;--s5:#9aa0a8}}
*{box-sizing:border-box}
body{margin:0;background:var(--paper);color:var(--ink);font:15px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,
"Helvetica Neue","DejaVu Sans",sans-serif;-webkit-text-size-adjust:100%}
main{max-width:1360px;margin:0 auto;padding:40px 32px 64px}
header{margin-bottom:36px}
.eyebrow{margin:0 0 4px;color:var(--soft);font-size:13px}
h1{margin:0 0 10px;font-size:32px;line-height:1.15;font-weight:650;letter-spacing:-.015em;overflow-wrap:anywhere}
.verdict{margin:0;max-width:92ch;font-size:18px;line-height:1.5;text-wrap:pretty}
h2{margin:0 0 4px;font-size:20px;line-height:1.25;font-weight:650;letter-spacing:-.008em}
section{margin-top:44px;padding-top:20px;border-top:1px solid var(--line)}
.lead{margin:0;max-width:108ch;color:var(--soft)}
.notice{margin:16px 0 0;padding:9px 14px;max-width:90ch;border-left:3px solid var(--alarm);background:var(--alarm-card)}
.notice strong,.warn th{color:var(--alarm)}
.gallery{display:grid;grid-template-columns:repeat(var(--columns),minmax(0,1fr));gap:24px 20px;margin-top:18px}
.gallery.small{gap:16px 12px}
figure{margin:0;min-width:0}
.picture{position:relative;line-height:0}
.picture img{display:block;width:100%;height:auto;border-radius:3px;background:var(--card)}
.crisp{image-rendering:pixelated}
.frame{position:absolute;border:2px solid #fff;outline:1.5px solid #000;border-radius:1px}
figcaption{margin-top:7px;line-height:1.4;overflow-wrap:anywhere}
figcaption b{font-weight:600}
figcaption span{display:block;color:var(--soft);font-size:13.5px}
.small figcaption{margin-top:4px;font-size:12.5px}
.small figcaption span{font-size:12px}
.bar{position:relative;margin-top:8px;font-size:12px;line-height:1;color:var(--soft);font-variant-numeric:tabular-nums}
.bar img{display:block;width:100%;height:9px;border-radius:2px;image-rendering:auto}
.bar .ticks{position:relative;height:17px}
.bar .ticks span{position:absolute;top:5px;transform:translateX(-50%);white-space:nowrap}
.bar .ticks span:first-child{transform:none}
.bar .ticks span:last-child{transform:translateX(-100%)}
.bar .ticks span::before{content:"";position:absolute;left:50%;top:-5px;height:3px;border-left:1px solid var(--soft)}
.bar .ticks span:first-child::before{left:0}
.bar .ticks span:last-child::before{left:auto;right:0}
.shared{max-width:640px;margin:14px 0 28px}
.scroll{overflow-x:auto;margin-top:16px}
table{border-collapse:collapse;font-variant-numeric:tabular-nums;font-size:14px}
th,td{padding:6px 0 6px 28px;text-align:right;border-bottom:1px solid var(--line);font-weight:400;white-space:nowrap}
th:first-child{padding-left:0;text-align:left}tbody th:first-child{white-space:normal;min-width:9em}
thead th{color:var(--soft);font-size:13px;vertical-align:bottom;border-bottom:1px solid var(--soft)}
td strong{font-weight:700}
.dense th,.dense td{padding-left:15px}.dense th:first-child{padding-left:0}
h3{margin:22px 0 0;font-size:15px;font-weight:650}
.aside{margin-left:10px;font-size:12.5px;font-weight:600}
.warn th,.warn td{background:var(--alarm-card)}
.text td{text-align:left;white-space:normal;overflow-wrap:anywhere}
.meter{display:inline-flex;align-items:center;gap:9px}
.value{min-width:4.4em}
.track{width:72px;height:5px;border-radius:3px;background:var(--line);overflow:hidden}
.dense thead th{white-space:normal}
.dense .track{width:36px}.dense .meter{gap:6px}.dense .value{min-width:3.8em}
.track i{display:block;height:100%;background:var(--accent)}
.beside{display:flex;flex-wrap:wrap;gap:24px 56px;align-items:flex-start;margin-top:18px}
.beside>.scroll{margin-top:0}
.half{max-width:480px}.pair{display:grid;grid-template-columns:1fr 1fr;gap:4px}
.plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,380px),1fr));gap:24px 28px;margin-top:18px}
.plot{display:block;width:100%;max-width:640px;height:auto;overflow:visible;font-family:inherit}
.plot .title{font-size:14px;font-weight:600;fill:var(--ink)}
.plot .tick{font-size:11.5px;fill:var(--soft);font-variant-numeric:tabular-nums}
.plot .label{font-size:12.5px;fill:var(--ink)}
.grid{stroke:var(--line);stroke-width:1;fill:none}.base{stroke:var(--soft);stroke-width:1;fill:none}
.line{fill:none;stroke-width:1.9;stroke-linejoin:round;stroke-linecap:round}
.dashed{stroke-dasharray:5 4;stroke-width:1.5}
.again{stroke-dasharray:1.5 3}
.third{stroke-dasharray:8 3 1.5 3}
.line.s0{stroke:var(--s0)}.line.s1{stroke:var(--s1)}.line.s2{stroke:var(--s2)}.line.s3{stroke:var(--s3)}.line.s4{stroke:var(--s4)}
.line.s5{stroke:var(--s5)}
.dot.s0{fill:var(--s0)}.dot.s1{fill:var(--s1)}.dot.s2{fill:var(--s2)}.dot.s3{fill:var(--s3)}.dot.s4{fill:var(--s4)}.dot.s5{fill:var(--s5)}
.matrix .inside{font-size:12px;fill:var(--ink);text-anchor:middle;font-variant-numeric:tabular-nums}
.matrix .strong{fill:var(--paper)}
.cell{fill:var(--card)}rect.hit{fill:var(--s0)}rect.miss{fill:var(--s1)}rect.true{fill:none;stroke:var(--s1);stroke-width:1.4}
.plot.wide{max-width:none}.panels{display:flex;flex-wrap:wrap;gap:18px 26px;margin-top:18px}.panels>svg{flex:0 0 auto}
.poses{display:flex;flex-wrap:wrap;gap:8px 14px;margin-top:8px}
.poses figure{flex:0 0 auto}.pose{display:block;height:150px;width:auto}
.poses figcaption{font-size:12.5px;margin-top:0}.poses figcaption span{font-size:12px}
.pose path{fill:none;stroke-linecap:round;stroke-linejoin:round}
.pose .rest{stroke:var(--soft);stroke-width:2;opacity:.55}
.pose .group{stroke:var(--s1);stroke-width:3.2}
.pose .group.faint{stroke-width:1.6;opacity:.35}.pose .joint{fill:var(--s1)}
details{margin-top:16px}
summary{cursor:pointer;font-weight:600}
summary:focus-visible{outline:2px solid var(--accent);outline-offset:3px}
code{font:12.5px/1.5 ui-monospace,"SF Mono",Menlo,Consolas,"DejaVu Sans Mono",monospace;overflow-wrap:anywhere}
.prose p{max-width:78ch;margin:10px 0 0}
@media(max-width:900px){main{padding:24px 16px 48px}h1{font-size:26px}.verdict{font-size:16px}
.gallery{grid-template-columns:repeat(min(2,var(--columns)),minmax(0,1fr));gap:18px 12px}
.gallery.small{grid-template-columns:repeat(min(4,var(--columns)),minmax(0,1fr))}}
@media(max-width:520px){.gallery{grid-template-columns:minmax(0,1fr)}.gallery.small{grid-template-columns:repeat(2,minmax(0,1fr))}}
@media print{main{max-width:none;padding:0}figure,tr,.plot{break-inside:avoid}}
"""
