// SPDX-License-Identifier: BSD-3-Clause
// A Java agent for tests: prints, once a second, what the table in LCM spy's window shows, one line a channel:
// "row CHANNEL TYPE MESSAGES UNDECODABLE". The spy itself runs unchanged.
import java.awt.Component;
import java.awt.Container;
import java.awt.Frame;
import javax.swing.JTable;
import javax.swing.SwingUtilities;

public class SpyTableAgent {
    public static void premain(String arguments) {
        Thread watcher = new Thread(SpyTableAgent::watch, "spy-table-agent");
        watcher.setDaemon(true);
        watcher.start();
    }

    private static void watch() {
        while (true) {
            try {
                Thread.sleep(1000);
                SwingUtilities.invokeAndWait(SpyTableAgent::print);
            } catch (Exception | NoClassDefFoundError | java.awt.AWTError failure) {
                return;
            }
        }
    }

    private static void print() {
        for (Frame frame : Frame.getFrames()) {
            JTable table = "LCM Spy".equals(frame.getTitle()) ? find(frame) : null;
            if (table == null) continue;
            int last = table.getColumnCount() - 1;
            for (int row = 0; row < table.getRowCount(); ++row) {
                System.err.println("row " + table.getValueAt(row, 0) + " " + table.getValueAt(row, 1) + " "
                    + table.getValueAt(row, 2) + " " + table.getValueAt(row, last));
            }
        }
    }

    private static JTable find(Container parent) {
        for (Component child : parent.getComponents()) {
            JTable found = child instanceof JTable ? (JTable) child
                : child instanceof Container ? find((Container) child) : null;
            if (found != null) return found;
        }
        return null;
    }
}
