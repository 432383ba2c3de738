//! Digits for colour bars in pictures without text.

use crate::canvas::Raster;

/// Pixels of a glyph, and of each of its dots.
const SIZE: [usize; 2] = [5, 7];
const DOT: usize = 2;

/// Rows of a glyph from top to bottom, the leftmost dot in bit 4.
fn rows(character: char) -> [u8; 7] {
    match character {
        '0' => [0b01110, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01110],
        '1' => [0b00100, 0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110],
        '2' => [0b01110, 0b10001, 0b00001, 0b00110, 0b01000, 0b10000, 0b11111],
        '3' => [0b01110, 0b10001, 0b00001, 0b00110, 0b00001, 0b10001, 0b01110],
        '4' => [0b00010, 0b00110, 0b01010, 0b10010, 0b11111, 0b00010, 0b00010],
        '5' => [0b11111, 0b10000, 0b11110, 0b00001, 0b00001, 0b10001, 0b01110],
        '6' => [0b00110, 0b01000, 0b10000, 0b11110, 0b10001, 0b10001, 0b01110],
        '7' => [0b11111, 0b00001, 0b00010, 0b00100, 0b00100, 0b01000, 0b01000],
        '8' => [0b01110, 0b10001, 0b10001, 0b01110, 0b10001, 0b10001, 0b01110],
        '9' => [0b01110, 0b10001, 0b10001, 0b01111, 0b00001, 0b00010, 0b01100],
        '-' => [0, 0, 0, 0b01110, 0, 0, 0],
        '+' => [0, 0, 0b00100, 0b01110, 0b00100, 0, 0],
        '.' => [0, 0, 0, 0, 0, 0b01100, 0b01100],
        'e' => [0, 0, 0b01110, 0b10001, 0b11111, 0b10000, 0b01110],
        _ => [0; 7],
    }
}

/// Writes a number with its middle at a height.
pub(crate) fn write(raster: &mut Raster, text: &str, left: usize, middle: usize) {
    let top = middle.saturating_sub(SIZE[1] * DOT / 2);
    for (k, character) in text.chars().enumerate() {
        let start = left + k * (SIZE[0] + 1) * DOT;
        for (row, bits) in rows(character).iter().enumerate() {
            for column in (0..SIZE[0]).filter(|column| bits >> (SIZE[0] - 1 - column) & 1 == 1) {
                for dot in 0..DOT * DOT {
                    let (x, y) = (start + column * DOT + dot % DOT, top + row * DOT + dot / DOT);
                    if x < raster.width && y < raster.height {
                        let place = 3 * (y * raster.width + x);
                        raster.colours[place..place + 3].fill(40);
                    }
                }
            }
        }
    }
}
