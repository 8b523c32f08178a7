// SPDX-License-Identifier: BSD-3-Clause
// The look of report.html: quiet on the screen, and on paper the same with ink saved.
#pragma once

namespace sortie::toolchain {

/// Style sheet of the page.
inline constexpr const char* kPageStyle = R"css(
:root{--ink:#1a1f24;--soft:#5b646d;--line:#d5d9de;--blue:#0072b2;--bad:#b84a00}
*{box-sizing:border-box}
body{margin:0;background:#f3f5f7;color:var(--ink);font:14px/1.45 system-ui,"DejaVu Sans",Arial,sans-serif}
main{max-width:1060px;margin:0 auto;padding:28px 34px 20px;background:#fff;min-height:100vh}
header{border-bottom:3px solid var(--blue);padding-bottom:8px;margin-bottom:18px;display:flex;align-items:baseline;gap:18px;flex-wrap:wrap}
header.run{margin-top:56px;break-before:page}a{color:var(--blue)}
h1{font-size:26px;margin:0;letter-spacing:-.01em}
header p{margin:0;color:var(--soft)}
h2{font-size:17px;margin:30px 0 10px}
.tiles{display:flex;flex-wrap:wrap;gap:10px}
.tile{border:1px solid var(--line);border-radius:6px;padding:9px 14px 8px;flex:1 1 105px}
.tile b{white-space:nowrap;display:block;font-size:22px;font-weight:600;line-height:1.2;font-variant-numeric:tabular-nums}
.tile i{font-style:normal;font-size:14px;font-weight:400;color:var(--soft);margin-left:4px}
.tile span{color:var(--soft);font-size:12.5px}
.tile.bad{border-color:var(--bad)}.tile.bad b,td.bad{color:var(--bad)}
td.bad{font-weight:600}
.warning{border-left:4px solid #e69f00;background:#fdf6e7;padding:8px 12px;margin:12px 0 0}
table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums}
th{font-weight:500;color:var(--soft);text-align:left;font-size:12.5px;border-bottom:1px solid #8a939c;padding:3px 8px}
td{border-bottom:1px solid #e8ebee;padding:4px 8px;white-space:nowrap}
.n{text-align:right}.u{color:var(--soft);padding-left:0}
td.bar svg{vertical-align:middle}td.bar small{color:var(--soft);margin-left:7px}
.note{color:var(--soft);font-size:12.5px;margin:6px 0}
.split{display:flex;gap:26px;align-items:flex-start;flex-wrap:wrap}.split>div:first-child{flex:1 1 600px}.split>div:last-child{flex:1 1 240px}
svg{max-width:100%;height:auto}
.grid{display:grid;grid-template-columns:repeat(auto-fill,minmax(430px,1fr));gap:12px 16px}
.counters{columns:3;column-gap:34px}
.counters div{display:flex;justify-content:space-between;break-inside:avoid;border-bottom:1px solid #e8ebee;padding:3px 0;font-variant-numeric:tabular-nums}
.counters .zero{color:#8a939c}.counters b{font-weight:600}.counters .zero b{font-weight:400}
.doctor td{white-space:normal;vertical-align:top}.doctor code{font-size:12px;overflow-wrap:anywhere}
.health{display:inline-block;min-width:62px;text-align:center;border-radius:9px;padding:0 8px;font-size:12px;background:#e4e8ec}
.health.good{background:#d9efe6;color:#00543d}.health.warn{background:#fbeac2;color:#664400}.health.bad{background:#f6d5c2;color:#7a2e00;font-weight:600}
footer{margin-top:34px;border-top:1px solid var(--line);padding-top:10px}
dl{display:grid;grid-template-columns:max-content 1fr;gap:3px 16px;margin:0;font-size:12.5px}
dt{color:var(--soft)}dd{margin:0;font-family:ui-monospace,"DejaVu Sans Mono",monospace;overflow-wrap:anywhere}
@media screen and (max-width:1000px){main{padding:16px 12px}table{font-size:12px}th,td{padding:3px 3px}th{font-size:11px}td.bar svg{width:36px}td.bar small{margin-left:3px}.grid{grid-template-columns:1fr}}
@media print{@page{size:A4;margin:13mm}*{print-color-adjust:exact;-webkit-print-color-adjust:exact}
body{background:#fff;font-size:11px}main{padding:0;max-width:none;min-height:0}h2{break-after:avoid;margin-top:18px}
tr,svg,.tile{break-inside:avoid}th,.note{font-size:10px}.tiles{gap:6px}.tile{flex:1 1 70px;padding:6px 9px}.tile b{font-size:16px}.tile i{font-size:11px}.tile span{font-size:10px}.grid{grid-template-columns:1fr 1fr}.counters{columns:3}
.split>div:first-child{flex:0 0 68%}.split>div:last-child{flex:1 1 20%}.split{flex-wrap:nowrap}td{padding:2px 5px}}
)css";

}  // namespace sortie::toolchain
