(function () {
  'use strict';
  // Tables sort by a click on a heading; without scripts they are just not sortable.
  function valueOf(row, column) {
    var cell = row.cells[column];
    var number = cell.getAttribute('data-sort');
    return number === null ? cell.textContent.trim() : Number(number);
  }
  function sort(table, column, button) {
    var body = table.tBodies[0];
    var rows = Array.prototype.slice.call(body.rows);
    var head = button.parentNode;
    var isRising = head.getAttribute('aria-sort') !== 'ascending';
    rows.sort(function (a, b) {
      var x = valueOf(a, column), y = valueOf(b, column);
      var order;
      if (typeof x === typeof y) {
        order = typeof x === 'number' ? x - y : x.localeCompare(y);
        return isRising ? order : -order;
      }
      // What is no number stays at the end.
      return typeof x === 'number' ? -1 : 1;
    });
    rows.forEach(function (row) { body.appendChild(row); });
    Array.prototype.forEach.call(head.parentNode.cells, function (cell) { cell.removeAttribute('aria-sort'); });
    head.setAttribute('aria-sort', isRising ? 'ascending' : 'descending');
  }
  document.querySelectorAll('table.numbers').forEach(function (table) {
    var heads = table.tHead.rows[0].cells;
    Array.prototype.forEach.call(heads, function (head, column) {
      var button = document.createElement('button');
      button.type = 'button';
      button.textContent = head.textContent;
      head.textContent = '';
      head.appendChild(button);
      button.addEventListener('click', function () { sort(table, column, button); });
    });
  });
  // On paper everything is open.
  var closed = [];
  window.addEventListener('beforeprint', function () {
    closed = Array.prototype.filter.call(document.querySelectorAll('details'), function (one) { return !one.open; });
    closed.forEach(function (one) { one.open = true; });
  });
  window.addEventListener('afterprint', function () {
    closed.forEach(function (one) { one.open = false; });
  });
}());
