// The last of a page's scripts: from now on a click does what it says. Before, it would send forms as browsers do by themselves.
document.getElementById("main").inert = false;
